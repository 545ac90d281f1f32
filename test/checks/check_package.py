#!/usr/bin/python3
"""Fails where package.xml does not declare just what the build looks for and the sources include.

usage: check_package.py REPOSITORY
"""

import pathlib
import re
import sys
import xml.etree.ElementTree

# What find_package and find_library look for, and the rosdep key of it. None: part of the compiler or optional.
KEY_OF_PACKAGE = {
    'Boost': 'libboost-dev', 'CLI11': 'cli11', 'Ceres': 'libceres-dev', 'Eigen3': 'eigen', 'GTest': 'gtest',
    'OpenCV': 'libopencv-dev', 'PCL': 'libpcl-all-dev', 'pcl_io': 'libpcl-all-dev', 'SQLite3': 'libsqlite3-dev',
    'LibXml2': 'libxml2', 'Qt5': 'qtbase5-dev', 'Qt6': None, 'rviz': 'rviz', 'TBB': 'tbb', 'benchmark': 'benchmark', 'embree': 'embree', 'openblas': 'libopenblas-dev',
    'spdlog': 'spdlog',
    'tsl-robin-map': 'robin-map-dev', 'yaml-cpp': 'yaml-cpp', 'catkin': 'catkin',
    'opengv': None, 'Threads': None, 'OnnxRuntime': None, 'Torch': None, 'onnxruntime': None, 'Python3': None,
}
# Likewise of the first part of an included path.
KEY_OF_INCLUDE = {
    'CLI': 'cli11', 'Eigen': 'eigen', 'unsupported': 'eigen', 'benchmark': 'benchmark', 'boost': 'libboost-dev',
    'cblas.h': 'libopenblas-dev',
    'ceres': 'libceres-dev', 'embree3': 'embree', 'embree4': 'embree', 'gmock': 'gtest', 'gtest': 'gtest',
    'opencv2': 'libopencv-dev', 'pcl': 'libpcl-all-dev', 'ros': 'roscpp', 'spdlog': 'spdlog',
    'libxml': 'libxml2', 'sqlite3.h': 'libsqlite3-dev', 'tbb': 'tbb', 'tsl': 'robin-map-dev', 'yaml-cpp': 'yaml-cpp',
    'opengv': None,  # compared with in a benchmark where it is installed
    'ATen': None, 'torch': None, 'onnxruntime_cxx_api.h': None,  # the learned matcher, which is optional
    'emmintrin.h': None, 'immintrin.h': None, 'fcntl.h': None, 'malloc.h': None, 'poll.h': None, 'sched.h': None, 'signal.h': None, 'sys': None,
    'unistd.h': None,
}
# What no source names, and where it is in use: a file, and the words that show it there.
USED_ELSEWHERE = {
    'catkin': ('src/mlic_ros/catkin.cmake', 'find_package(catkin'),
    'libboost-dev': ('src/mlic_ros/bag/rig_draft.cc', 'boost::shared_ptr'),
    'libopenblas-dev': ('CMakeLists.txt', 'openblas'),
    'message_generation': ('src/mlic_ros/catkin.cmake', 'generate_messages('),
    'message_runtime': ('src/mlic_ros/catkin.cmake', 'message_runtime'),
    'python3-yaml': ('test/mlic_ros/end_to_end_test.py', 'import yaml'),
    'roslaunch': ('launch/calibrate.launch', '<launch>'),
    'rospy': ('test/mlic_ros/check_calibration.py', 'import rospy'),
    'rostest': ('test/mlic_ros/CMakeLists.txt', 'rostest'),
    'libqt5-widgets': ('src/mlic_ros/panel/CMakeLists.txt', 'Qt5 QUIET COMPONENTS Widgets'),
}
LICENCE = 'BSD-3-Clause'
INCLUDE = re.compile(r'^\s*#\s*include\s*<([^>]+)>', re.MULTILINE)
FOUND = re.compile(r'find_(?:package|library)\(\s*(\w[\w-]*)([^)]*)\)')
SOURCES = {'.h', '.cc'}
ROS_COMPONENT = re.compile(r'[a-z][a-z0-9_]*')


def cmake_files(root):
    yield root / 'CMakeLists.txt'
    for folder in ('src', 'test', 'benchmark', 'cmake'):
        for path in sorted((root / folder).rglob('*')):
            if path.name == 'CMakeLists.txt' or path.suffix == '.cmake':
                yield path


def keys_of_cmake(root, faults):
    """rosdep key -> where the build looks for it."""
    keys = {}
    for path in cmake_files(root):
        text = re.sub(r'#[^\n]*', '', path.read_text(encoding='utf-8'))
        for call in FOUND.finditer(text):
            library = 'find_library' in call.group(0)
            name = call.group(2).split()[0] if library else call.group(1)
            if name not in KEY_OF_PACKAGE:
                faults.append(f'{path}: {name} is looked for, but check_package.py knows no rosdep key of it')
            names = {KEY_OF_PACKAGE.get(name)}
            if name == 'catkin':
                names |= {word for word in call.group(2).split() if ROS_COMPONENT.fullmatch(word)}
            for key in names - {None}:
                keys.setdefault(key, path)
    return keys


def keys_of_includes(root, faults):
    """rosdep key -> a source that includes it."""
    keys = {}
    for folder in ('src', 'test', 'benchmark'):
        for path in sorted((root / folder).rglob('*')):
            if path.suffix not in SOURCES:
                continue
            for header in INCLUDE.findall(path.read_text(encoding='utf-8')):
                first = header.split('/')[0]
                if '/' not in header and '.' not in header:
                    continue  # the standard library
                if first in KEY_OF_INCLUDE:
                    key = KEY_OF_INCLUDE[first]
                elif '/' in header and ROS_COMPONENT.fullmatch(first):
                    key = first  # a ROS package
                else:
                    faults.append(f'{path}: <{header}>: check_package.py knows no rosdep key of it')
                    continue
                if key is not None:
                    keys.setdefault(key, path)
    return keys


def check(root):
    faults = []
    package = xml.etree.ElementTree.parse(root / 'package.xml').getroot()
    declared = {element.text for element in package if element.tag.endswith('depend')}
    used = {**keys_of_includes(root, faults), **keys_of_cmake(root, faults)}
    for key in sorted(set(used) - declared):
        faults.append(f'{used[key]} needs {key}, which package.xml does not declare')
    for key in sorted(declared - set(used)):
        place, words = USED_ELSEWHERE.get(key, (None, None))
        if place is None or words not in (root / place).read_text(encoding='utf-8'):
            faults.append(f'package.xml declares {key}, which nothing uses')
    if package.findtext('license') != LICENCE or 'BSD 3-Clause' not in (root / 'LICENSE').read_text(encoding='utf-8'):
        faults.append(f'package.xml and LICENSE do not both say {LICENCE}')
    return faults, len(declared)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    faults, count = check(pathlib.Path(sys.argv[1]))
    if faults:
        sys.exit('\n'.join(faults))
    print(f'check_package.py: {count} dependencies, each declared and used')


main()
