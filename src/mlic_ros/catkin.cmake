# catkin package.
