#!/usr/bin/python3
"""Fails when a test in the source tree is not run by ctest.

usage: check_registered.py TEST_DIRECTORY BUILD_DIRECTORY | --self-test

A test is a file NAME_test.cc (ctest knows it by folder and name, see test/CMakeLists.txt), NAME_test.py, check_NAME.py
or check_NAME.sh (in the command of a test, or in the .test file of a rostest). The build must be configured with all of
ROS and the simulator.
"""

import json
import pathlib
import re
import subprocess
import sys


def program_of(path):
    """Name in ctest of the gtest program of the file at `path`, relative to test/."""
    parts = path.parts[1:] if path.parts[0] == 'mlic_core' else path.parts
    return '_'.join(parts[:-1] + (path.stem,))


def missing(files, tests):
    """Of `files` (paths relative to test/, with the text of .test files), what none of `tests` (name, command) runs."""
    names = {name for name, _ in tests}
    commands = [part for _, command in tests for part in command]
    commands += [text for path, text in files.items() if path.suffix == '.test' and
                 any(part.endswith('/' + str(path)) for part in commands)]
    found = []
    for path in files:
        if path.name.endswith('_test.cc'):
            run = program_of(path) in names
        elif re.search(r'_test\.py$|^check_\w+\.(py|sh)$', path.name):
            run = any(path.name in part for part in commands)
        else:
            continue
        if not run:
            found.append(path)
    return found


def self_test():
    files = {pathlib.Path(name): text for name, text in [
        ('mlic_core/lidar/odometry_test.cc', ''), ('mlic_core/io/result/file_test.cc', ''),
        ('mlic_sim/imu_test.cc', ''), ('mlic_ros/programs_test.py', ''), ('mlic_ros/check_calibration.py', ''), ('checks/check_format.sh', ''),
        ('mlic_ros/calibrate.test', '<test type="check_calibration.py" />')]}
    tests = [('lidar_odometry_test', ['lidar_odometry_test']), ('io_result_file_test', []), ('mlic_sim_imu_test', []),
             ('programs', ['python3', '/src/test/mlic_ros/programs_test.py']),
             ('launch', ['rostest', '/src/test/mlic_ros/calibrate.test']),
             ('format', ['/src/test/checks/check_format.sh'])]
    assert missing(files, tests) == [], missing(files, tests)
    for number, expected in [(0, 1), (1, 1), (2, 1), (3, 1), (4, 1), (5, 1)]:
        found = missing(files, tests[:number] + tests[number + 1:])
        assert len(found) == expected, f'without {tests[number]}: {found}'
    print('check_registered.py: 6 planted omissions found')


def main():
    if sys.argv[1:] == ['--self-test']:
        self_test()
        return
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    top = pathlib.Path(sys.argv[1])
    listed = subprocess.run(['ctest', '--show-only=json-v1'], cwd=sys.argv[2], capture_output=True, check=True)
    tests = [(test['name'], test.get('command', [])) for test in json.loads(listed.stdout)['tests']]
    files = {path.relative_to(top): path.read_text(encoding='utf-8') if path.suffix == '.test' else ''
             for path in sorted(top.rglob('*')) if path.is_file()}
    found = missing(files, tests)
    if found or not tests:
        sys.exit('\n'.join(f'{path}: ctest does not run it' for path in found) +
                 f'\ncheck_registered.py: {len(found)} tests are not registered')
    print(f'check_registered.py: every test below {top.name}/ is one of the {len(tests)} that ctest runs')


if __name__ == '__main__':
    main()
