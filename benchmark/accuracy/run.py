#!/usr/bin/python3
"""Calibrates simulated drives with the programs of a build and writes one CSV line for each scenario and seed.

usage: run.py [--build DIR] [--scenarios NAME,NAME] [--seeds 11,12,13] [--rows FILE.csv]

Drives are simulated, calibrated and compared with their truth by `simulate`, `calibrate` and `evaluate`, as a user
would. A line that is in the file already is not made again, so a run that was stopped goes on. Default file:
benchmark/accuracy/rows/COMMIT.csv. Columns: row.py.
"""

import argparse
import csv
import pathlib
import shutil
import sys
import tempfile

import row
import scenarios
from programs import REPOSITORY, Usage, append_rows, commit_of, must

HERE = pathlib.Path(__file__).resolve().parent


def measure(programs, scenario, seed, folder):
    """Simulates and calibrates one drive in `folder`; its row as a dictionary."""
    bag, output, evaluation = folder / 'drive.bag', folder / 'calibration', folder / 'evaluation'
    simulation = [programs / 'simulate', '--sensors', REPOSITORY / 'config/simulation' / scenario.sensors, '--scenario',
                  scenario.motion, '--duration', scenario.seconds, '--seed', seed, '--output', bag]
    must(Usage(simulation + ([] if scenario.guess else ['--no-guess']), folder / 'simulate.log'), 'simulate',
         folder / 'simulate.log')
    used = Usage([programs / 'calibrate', '--rig', folder / 'drive_rig.yaml', '--bag', bag, '--output', output],
                 folder / 'calibrate.log')
    found = output / 'calibration.yaml'
    if found.exists():
        evaluated = Usage([programs / 'evaluate', '--bag', bag, '--calibration', found, '--truth',
                           folder / 'drive_truth.yaml', '--output', evaluation], folder / 'evaluate.log')
        must(evaluated, 'evaluate', folder / 'evaluate.log')
    values = {'scenario': scenario.name, 'seed': seed, 'duration': scenario.seconds, 'exit': used.exit,
              'cpu_s': f'{used.cpu:.1f}', 'wall_s': f'{used.wall:.1f}', 'memory_mb': f'{used.memory:.0f}'}
    values.update(row.errors_of(found, folder / 'drive_truth.yaml', evaluation))
    return values


def rows_done(path):
    if not path.exists():
        return set()
    with open(path, newline='') as file:
        return {(line['scenario'], int(line['seed']), float(line['duration'])) for line in csv.DictReader(file)}


def append(path, values):
    """The row of a drive."""
    append_rows(path, row.COLUMNS, [values])


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--build', type=pathlib.Path, default=REPOSITORY / 'build', help='of the programs')
    parser.add_argument('--scenarios', default=','.join(scenarios.DEFAULT), help='names of scenarios.py')
    parser.add_argument('--seeds', default='11,12,13', help='by default seeds that no constant was chosen on')
    parser.add_argument('--rows', type=pathlib.Path, help='CSV file that lines are added to')
    arguments = parser.parse_args()
    unknown = [name for name in arguments.scenarios.split(',') if name not in scenarios.BY_NAME]
    if unknown:
        parser.error(f'no scenario {unknown[0]}; there are {", ".join(scenarios.BY_NAME)}')
    return arguments


def main():
    arguments = parse()
    programs = arguments.build.resolve() / 'devel/lib/mlic'
    for name in ['simulate', 'calibrate', 'evaluate']:
        if not (programs / name).exists():
            sys.exit(f'run.py: no program {programs / name}; build first, or name the build directory by --build')
    commit = commit_of(REPOSITORY)
    rows = arguments.rows or HERE / 'rows' / f'{commit}.csv'
    done = rows_done(rows)
    for name in arguments.scenarios.split(','):
        scenario = scenarios.BY_NAME[name]
        for seed in map(int, arguments.seeds.split(',')):
            if (name, seed, float(scenario.seconds)) in done:
                continue
            folder = pathlib.Path(tempfile.mkdtemp(prefix='mlic_accuracy_'))
            try:
                values = dict(measure(programs, scenario, seed, folder), commit=commit)
            finally:
                shutil.rmtree(folder)
            append(rows, values)
            print(f'{name} seed {seed}: {values["verdict"]}, {values["cpu_s"]} s of CPU', flush=True)
    print(f'run.py: rows in {rows}')


if __name__ == '__main__':
    main()
