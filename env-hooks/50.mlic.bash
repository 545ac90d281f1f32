# Completion of the programs' options, wherever the workspace lies; scripts need none.
if [[ $- == *i* && -r $CATKIN_ENV_HOOK_WORKSPACE/share/mlic/completion.bash ]]; then
  . "$CATKIN_ENV_HOOK_WORKSPACE/share/mlic/completion.bash"
fi
