#!/usr/bin/env bash
# Runs a command and writes its exit status to a file: roslaunch exits with 0 whatever became of its nodes, so
# demo.sh puts this in front of calibrate (launch-prefix, through MLIC_LAUNCH_PREFIX).
#   record_status.sh FILE COMMAND [ARG ...]
set -u
file=$1
shift
# An interrupt is the command's to handle; this waits for its end.
trap '' INT TERM
(trap - INT TERM; exec "$@") &
child=$!
trap 'kill -INT $child 2>/dev/null' INT
trap 'kill -TERM $child 2>/dev/null' TERM
status=0
wait $child || status=$?
while kill -0 $child 2>/dev/null; do
  status=0
  wait $child || status=$?
done
echo "$status" >"$file"
exit "$status"
