"""Runs the programs of a build, says what they took, and keeps rows of what was measured."""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import time

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent.parent


def commit_of(repository):
    """Short name of the commit, with a + where tracked files differ from it."""
    def git(*arguments):
        return subprocess.run(['git', '-C', str(repository), *arguments], capture_output=True, text=True).stdout.strip()
    name = git('rev-parse', '--short=10', 'HEAD') or 'unknown'
    return name + ('+' if git('status', '--porcelain', '--untracked-files=no') else '')


def append_rows(path, columns, rows):
    """Adds dictionaries to a CSV file, which it begins with the columns' names. One write of them all, so that a killed
    run leaves no half of a drive."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = '' if path.exists() else ','.join(columns) + '\n'
    text += ''.join(','.join(str(line.get(column, '')) for column in columns) + '\n' for line in rows)
    with open(path, 'a', newline='') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


class Usage:
    """What a program and its children took: exit status, seconds, peak memory of the largest process in MB."""

    def __init__(self, command, log):
        start = time.monotonic()
        with open(log, 'wb') as output:
            process = subprocess.Popen([str(part) for part in command], stdin=subprocess.DEVNULL, stdout=output,
                                       stderr=subprocess.STDOUT)
            _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.exit = process.returncode
        self.wall = time.monotonic() - start
        self.cpu = used.ru_utime + used.ru_stime
        self.memory = used.ru_maxrss / 1024


def must(usage, program, log):
    if usage.exit:
        lines = pathlib.Path(log).read_text(errors='replace').splitlines()
        sys.exit(f'{program} ended with {usage.exit}: {lines[-1] if lines else "no output"}')


def gate(runner, runs, faults_of):
    """A gate's main: runs the script `runner` with each list of arguments on the build directory that the command line
    names, all into one file; ends the program with the faults found in its rows, if any. The rows."""
    if len(sys.argv) != 2:
        sys.exit(sys.modules['__main__'].__doc__)
    with tempfile.TemporaryDirectory(prefix='mlic_gate_') as folder:
        rows = pathlib.Path(folder) / 'rows.csv'
        for arguments in runs:
            subprocess.run([sys.executable, runner, '--build', sys.argv[1], *arguments, '--rows', rows], check=True)
        with open(rows, newline='') as file:
            lines = list(csv.DictReader(file))
    faults = faults_of(lines)
    if faults:
        sys.exit('\n'.join(faults))
    return lines
