"""Runs the programs of a build and says what they took."""

import os
import pathlib
import subprocess
import sys
import time

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent.parent


def commit_of(repository):
    """Short name of the commit, with a + where tracked files differ from it."""
    def git(*arguments):
        return subprocess.run(['git', '-C', str(repository), *arguments], capture_output=True, text=True).stdout.strip()
    name = git('rev-parse', '--short=10', 'HEAD') or 'unknown'
    return name + ('+' if git('status', '--porcelain', '--untracked-files=no') else '')


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
