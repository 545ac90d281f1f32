# A Debian package for the release that it is built on: `cmake --build BUILD --target package` in a build directory that
# was made with -DCATKIN_BUILD_BINARY_PACKAGE=ON -DCMAKE_INSTALL_PREFIX=/usr (scripts/make_deb.sh does both). It lies in
# Debian's layout for ROS, so that rosrun and roslaunch find the package without a workspace.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ${PROJECT_NAME})
set(CPACK_PACKAGE_CONTACT "${mlic_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Calibration of LiDARs, cameras and IMU from one recorded drive")
set(CPACK_SET_DESTDIR ON)  # one file lies in /etc
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/debian/conffiles "/etc/bash_completion.d/mlic\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/debian/conffiles)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# Libraries and their versions are read off the programs; what only runs beside them is named here.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3-roslaunch, rosbash, tf2-tools")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "colmap, rviz")
include(CPack)
