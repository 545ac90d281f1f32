#!/usr/bin/python3
"""Kills `calibrate` (SIGKILL) at random moments, starts it again, and compares what it ends with to an undisturbed run. Results that differ are kept in the folder.

usage: kill_series.py --build DIR --rig RIG.yaml --bag DRIVE.bag --folder DIR [--kills 20] [--seed 1] [--threads 2]

A round kills one run up to three times, each time at a moment drawn evenly from the undisturbed run's length, then lets
it end; rounds are added until there were as many kills as asked for. A line for each round; exit status 1 where a file of
a result differs. Checkpoints (stages/), log and report, which say when and where they were written, are not compared.
"""

import argparse
import pathlib
import random
import shutil
import subprocess
import sys
import time

NOT_COMPARED = ['log.txt', 'report.html', 'manifest.txt', 'stages']
KILLS_OF_A_ROUND = 3


def command(arguments, output):
    return [str(arguments.build / 'devel/lib/mlic/calibrate'), '--rig', str(arguments.rig), '--bag', str(arguments.bag),
            '--output', str(output), '--threads', str(arguments.threads)]


def start(arguments, output):
    return subprocess.Popen(command(arguments, output), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def contents(output):
    """Bytes of all files of the result that say no time and no path, by relative path."""
    return {path.relative_to(output): path.read_bytes() for path in sorted(output.rglob('*'))
            if path.is_file() and path.relative_to(output).parts[0] not in NOT_COMPARED}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--build', type=pathlib.Path, required=True)
    parser.add_argument('--rig', type=pathlib.Path, required=True)
    parser.add_argument('--bag', type=pathlib.Path, required=True)
    parser.add_argument('--folder', type=pathlib.Path, required=True)
    parser.add_argument('--kills', type=int, default=20)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--threads', type=int, default=2)
    arguments = parser.parse_args()
    draw = random.Random(arguments.seed)
    whole = arguments.folder / 'undisturbed'
    arguments.folder.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    status = start(arguments, whole).wait()
    length = time.monotonic() - began
    expected = contents(whole)
    if not expected:
        sys.exit(f'kill_series.py: the undisturbed run ended with {status} and left nothing in {whole}')
    print(f'undisturbed: exit {status} after {length:.1f} s, {len(expected)} files')
    kills = differing = 0
    while kills < arguments.kills:
        output = arguments.folder / f'killed_{kills}'
        for _ in range(min(KILLS_OF_A_ROUND, arguments.kills - kills)):
            process = start(arguments, output)
            try:
                process.wait(draw.uniform(0.0, length))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                kills += 1
        again = start(arguments, output).wait()
        found = contents(output)
        different = sorted(str(name) for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
        differing += bool(different)
        print(f'{kills} kills: exit {again}, ' + (f'different: {", ".join(different)}' if different else 'the same bytes'),
              flush=True)
        if not different:
            shutil.rmtree(output)
    sys.exit(1 if differing else 0)


if __name__ == '__main__':
    main()
