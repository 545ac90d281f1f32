#!/usr/bin/python3
"""Calibrates drives drawn from seeds and writes CSV rows, one for each drive and kind of parameter.

usage: run.py [--build DIR] [--kind lidar] [--split open,closed] [--seeds 1-10] [--effect none] [--rows FILE.csv]

Rig, world, IMU grade, motion, clock offsets and whether there is a guess follow from kind, split and seed
(families.py); an effect changes nothing else of the drive. `simulate` and `calibrate` run as a user would run them;
score.py compares the result with the truth. A drive that is in the file already is not made again, so a run that was
stopped goes on. Default file: benchmark/trials/results/KIND_COMMIT.csv.
"""

import argparse
import csv
import pathlib
import re
import shutil
import sys
import tempfile

import yaml

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / 'accuracy'))

import families
import score
from programs import REPOSITORY, Usage, append_rows, commit_of, must

HERE = pathlib.Path(__file__).resolve().parent


def seeds_of(text):
    """'1-3,7' as [1, 2, 3, 7]."""
    found = []
    for part in text.split(','):
        match = re.fullmatch(r'(\d+)(?:-(\d+))?', part)
        if not match:
            raise argparse.ArgumentTypeError(f'{part}: expected numbers such as 1-10,15')
        found += range(int(match.group(1)), int(match.group(2) or match.group(1)) + 1)
    return found


def measure(simulator, calibrator, trial, folder, threads):
    """Simulates and calibrates one trial in `folder`; its rows as dictionaries."""
    sensors, bag, output = folder / 'sensors.yaml', folder / 'drive.bag', folder / 'calibration'
    sensors.write_text(yaml.safe_dump(trial['sensors'], sort_keys=False))
    command = [simulator, '--sensors', sensors, '--scenario', trial['motion'], '--duration', trial['duration'], '--seed',
               trial['seed'], '--world', trial['world'], '--world-seed', trial['world_seed'], '--moving',
               trial['moving'], '--output', bag]
    must(Usage(command + ([] if trial['guess'] else ['--no-guess']), folder / 'simulate.log'), 'simulate',
         folder / 'simulate.log')
    used = Usage([calibrator, '--rig', folder / 'drive_rig.yaml', '--bag', bag, '--output', output, '--threads', threads],
                 folder / 'calibrate.log')
    rows, verdict, lost = score.score(output / 'calibration.yaml', folder / 'drive_truth.yaml')
    of_trial = {name: trial[name] for name in score.TRIAL if name in trial}
    of_trial.update(guess='yes' if trial['guess'] else 'no', verdict=verdict, lost=lost, exit=used.exit,
                    cpu_s=f'{used.cpu:.1f}')
    # A drive without a result has a row of its own, so that it counts.
    return [dict(of_trial, **line) for line in rows or [{'parameter': 'none', 'n': 0}]]


def key_of(line):
    return line['kind'], line['split'], int(line['seed']), line['effect']


def done_in(path):
    if not path.exists():
        return set()
    with open(path, newline='') as file:
        return {key_of(line) for line in csv.DictReader(file)}


def append(path, rows):
    """All rows of a drive."""
    append_rows(path, score.COLUMNS, rows)


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--build', type=pathlib.Path, default=REPOSITORY / 'build', help='of the programs')
    parser.add_argument('--simulator', type=pathlib.Path, help='another build\'s `simulate`, to compare estimators')
    parser.add_argument('--kind', choices=families.KINDS, default='lidar')
    parser.add_argument('--split', default='open,closed', help='families: open, closed or both')
    parser.add_argument('--seeds', type=seeds_of, default=seeds_of('1-10'), help='such as 1-10,15; of each split')
    parser.add_argument('--effect', choices=sorted(families.EFFECTS), default='none')
    parser.add_argument('--longer', type=float, default=1.0, metavar='TIMES', help='drives so many times as long')
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--commit', help='of the programs; default: that of the directory the build lies in')
    parser.add_argument('--rows', type=pathlib.Path, help='CSV file that rows are added to')
    parser.add_argument('--keep', type=pathlib.Path, help='folder in which the drives stay')
    arguments = parser.parse_args()
    if not arguments.longer > 0:
        parser.error(f'--longer: {arguments.longer}, expected more than 0')
    return arguments


def main():
    arguments = parse()
    programs = arguments.build.resolve() / 'devel/lib/mlic'
    simulator, calibrator = arguments.simulator or programs / 'simulate', programs / 'calibrate'
    for program in (simulator, calibrator):
        if not program.exists():
            sys.exit(f'run.py: no program {program}; build first, or name the build directory by --build')
    commit = arguments.commit or commit_of(arguments.build.resolve().parent)
    times = '' if arguments.longer == 1.0 else f'{arguments.longer:g}_times_'
    path = arguments.rows or HERE / 'results' / f'{arguments.kind}_{times}{commit}.csv'
    done = done_in(path)
    for seed in arguments.seeds:
        for split in arguments.split.split(','):
            trial = families.draw_trial(arguments.kind, seed, split, arguments.effect)
            trial['duration'] = round(arguments.longer * trial['duration'], 1)
            if key_of(trial) in done:
                continue
            if arguments.keep:
                arguments.keep.mkdir(parents=True, exist_ok=True)
            folder = pathlib.Path(tempfile.mkdtemp(prefix='mlic_trial_', dir=arguments.keep))
            try:
                rows = measure(simulator, calibrator, dict(trial, commit=commit), folder, arguments.threads)
            finally:
                if not arguments.keep:
                    shutil.rmtree(folder)
            append(path, rows)
            worst = max((float(line['worst_z']) for line in rows if line['n']), default=float('nan'))
            print(f'{split} {seed}: {trial["world"]}, {trial["motion"]}, {trial["rig"]}, {trial["imu"]}, '
                  f'{trial["effect"]}: {rows[0]["verdict"]}, worst z {worst:.1f}, {rows[0]["cpu_s"]} s of CPU'
                  + (f', {folder}' if arguments.keep else ''), flush=True)
    print(f'run.py: rows in {path}')


if __name__ == '__main__':
    main()
