#!/usr/bin/python3
"""Fails on an include in the wrong direction between the rooms of the code, and on a circle of includes between
units, also inside a room (docs/architecture.md).

usage: check_layers.py SOURCE_DIRECTORY | --self-test

A room of mlic_core includes itself and rooms of lower levels only; rooms of one level do not include each other.
mlic_sim includes only common, geometry and sensors of mlic_core, so that it shares no mistake with the estimator.
ROS headers are included in mlic_ros only, and nothing but mlic_ros includes mlic_ros. mlic_ros/display shows what the
programs do and does not know them.
A unit is a header with the source file of the same name.
"""

import pathlib
import re
import sys
import tempfile

LEVEL = {
    'common': 0,
    'geometry': 1,
    'sensors': 2, 'trajectory': 2, 'solver': 2,
    'result': 3, 'factors': 3, 'imu': 3, 'lidar': 3, 'camera': 3,
    'ingest': 4, 'crossmodal': 4, 'problem': 4,
    'association': 5, 'inspection': 5,
    'uncertainty': 6,
    'initialization': 7,
    'summary': 8,
    'pipeline': 9,
    'evaluation': 10, 'io': 10,
}
OF_THE_SIMULATOR = {'common', 'geometry', 'sensors'}
# First part of the path of a header of ROS.
OF_ROS = re.compile(r'^(ros|rosbag|roscpp|rosgraph_msgs|rosconsole|topic_tools|tf|tf2|tf2_\w+|\w+_msgs|mlic|rviz|pluginlib|'
                    r'cv_bridge|image_transport|pcl_conversions|pcl_ros|nodelet|actionlib|message_filters|class_loader)/')
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
SUFFIXES = {'.h', '.hpp', '.cc', '.cpp', '.inc'}


def fault(user, header):
    """What is wrong with the file at path `user` (parts below src) including `header`, or None."""
    package = user[0]
    if OF_ROS.match(header):
        return None if package == 'mlic_ros' else 'a header of ROS outside mlic_ros'
    used = header.split('/')
    if used[0] == 'mlic_ros':
        if package != 'mlic_ros':
            return 'mlic_ros is included by nothing but itself'
        if user[1] == 'display' and used[1] == 'programs':
            return 'mlic_ros/display does not know the programs'
        return None
    if used[0] == 'mlic_sim' and package == 'mlic_core':
        return 'the core does not know the simulator'
    if used[0] != 'mlic_core':
        return None
    room = used[1]
    if room not in LEVEL:
        return f'mlic_core has no room {room} in the table of levels'
    if package == 'mlic_sim' and room not in OF_THE_SIMULATOR:
        return f'mlic_sim includes only {", ".join(sorted(OF_THE_SIMULATOR))} of the core'
    if package == 'mlic_core' and len(user) > 2:
        own = user[1]
        if own not in LEVEL:
            return f'the room {own} is not in the table of levels'
        if room != own and LEVEL[room] >= LEVEL[own]:
            return f'{own} (level {LEVEL[own]}) includes {room} (level {LEVEL[room]})'
    return None


def circles(graph):
    """The circles of a graph {node: nodes}: each a sorted list of nodes that reach each other (Tarjan, 1972)."""
    found, order, low, stack = [], {}, {}, []

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for used in sorted(graph[node]):
            if used not in order:
                visit(used)
                low[node] = min(low[node], low[used])
            elif used in stack:
                low[node] = min(low[node], order[used])
        if low[node] == order[node]:
            at = stack.index(node)
            if len(stack) - at > 1:
                found.append(sorted(stack[at:]))
            del stack[at:]

    for node in sorted(graph):
        if node not in order:
            visit(node)
    return found


def unit(path):
    """A header and the source file of the same name are one unit."""
    return path.rsplit('.', 1)[0]


def check(source):
    """All faults below the directory `source` and the number of files looked at."""
    faults = []
    files = 0
    graph = {}
    for path in sorted(source.rglob('*')):
        if path.suffix not in SUFFIXES or not path.is_file():
            continue
        files += 1
        user = path.relative_to(source).parts
        used_units = graph.setdefault(unit('/'.join(user)), set())
        for number, line in enumerate(path.read_text(encoding='utf-8').splitlines(), 1):
            match = INCLUDE.match(line)
            if match:
                used_units.add(unit(match.group(1)))
            what = match and fault(user, match.group(1))
            if what:
                faults.append(f'{path}:{number}: {what}: {line.strip()}')
    graph = {user: used & graph.keys() - {user} for user, used in graph.items()}
    for circle in circles(graph):
        edges = [f'{a} -> {b}' for a in circle for b in sorted(graph[a] & set(circle))]
        faults.append(f'{source}: units that include each other: ' + ', '.join(edges))
    return faults, files


def judge(files):
    """The faults of a folder with these files, {path: includes}."""
    with tempfile.TemporaryDirectory() as folder:
        for name, headers in files.items():
            path = pathlib.Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text('#pragma once\n#include <vector>\n' + ''.join(f'#include "{h}"\n' for h in headers))
        faults, count = check(pathlib.Path(folder))
        assert count == len(files)
        return faults


def self_test():
    """Plants one violation of each rule, and one include that is right, and sees which are found."""
    planted = [
        ('mlic_core/sensors/a.h', 'mlic_core/trajectory/b.h', True),
        ('mlic_core/geometry/a.h', 'mlic_core/sensors/b.h', True),
        ('mlic_core/factors/a.cc', 'mlic_core/lidar/b.h', True),
        ('mlic_core/association/a.cc', 'mlic_core/uncertainty/b.h', True),
        ('mlic_core/io/a.cc', 'mlic_core/evaluation/b.h', True),
        ('mlic_core/io/a.cc', 'mlic_core/nowhere/b.h', True),
        ('mlic_core/attic/a.cc', 'mlic_core/common/b.h', True),
        ('mlic_core/pipeline/a.cc', 'ros/ros.h', True),
        ('mlic_core/pipeline/a.cc', 'sensor_msgs/Imu.h', True),
        ('mlic_core/pipeline/a.cc', 'mlic_ros/b.h', True),
        ('mlic_core/pipeline/a.cc', 'mlic_sim/b.h', True),
        ('mlic_sim/a.cc', 'mlic_core/trajectory/b.h', True),
        ('mlic_sim/a.cc', 'rosbag/bag.h', True),
        ('mlic_core/pipeline/a.cc', 'mlic_core/lidar/b.h', False),
        ('mlic_core/lidar/a.cc', 'mlic_core/lidar/b.h', False),
        ('mlic_core/lidar/a.cc', 'mlic_core/trajectory/b.h', False),
        ('mlic_sim/a.cc', 'mlic_core/sensors/b.h', False),
        ('mlic_ros/a.cc', 'mlic_sim/b.h', False),
        ('mlic_ros/display/a.cc', 'mlic_ros/programs/b.h', True),
        ('mlic_ros/programs/a.cc', 'mlic_ros/display/b.h', False),
        ('mlic_ros/a.cc', 'ros/ros.h', False),
    ]
    for user, header, wrong in planted:
        faults = judge({user: [header]})
        assert bool(faults) == wrong, f'{user} including {header}: found {faults}'
    room = 'mlic_core/lidar/'
    # A source file closes a circle as a header does; a unit may include itself, and two may share a third.
    round_trip = {room + 'a.h': [], room + 'a.cc': [room + 'a.h', room + 'b.h'], room + 'b.h': [room + 'c.h'],
                  room + 'c.h': [room + 'a.h']}
    faults = judge(round_trip)
    assert len(faults) == 1 and 'lidar/c -> mlic_core/lidar/a' in faults[0], faults
    two = {'mlic_sim/a.h': ['mlic_sim/b.h'], 'mlic_sim/b.h': ['mlic_sim/a.h']}
    assert len(judge({**round_trip, **two})) == 2
    diamond = {room + 'a.h': [room + 'b.h', room + 'c.h'], room + 'b.h': [room + 'd.h'], room + 'c.h': [room + 'd.h'],
               room + 'd.h': [], room + 'd.cc': [room + 'd.h']}
    assert not judge(diamond), judge(diamond)
    print(f'check_layers.py: {len(planted)} planted includes and 3 planted graphs judged rightly')


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if sys.argv[1] == '--self-test':
        self_test()
        return
    source = pathlib.Path(sys.argv[1])
    faults, files = check(source)
    if not files:
        sys.exit(f'check_layers.py: no source file in {source}')
    if faults:
        sys.exit('\n'.join(faults) + f'\ncheck_layers.py: {len(faults)} includes in the wrong direction or in a circle')
    print(f'check_layers.py: {files} files, every include in the right direction, no circle')


main()
