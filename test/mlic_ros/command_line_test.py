#!/usr/bin/python3
"""What every program says of itself, and what is made of it.

usage: command_line_test.py PROGRAM_DIRECTORY FOLDER_OF_COMPLETION_AND_MAN_PAGES VERSION PROGRAM...
"""
import gzip
import os
import re
import shutil
import subprocess
import sys
import unittest


def run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=60)


def program(name, *arguments):
    return run(os.path.join(PROGRAMS, name), *arguments)


def options_of(help_text):
    return set(re.findall(r'(?<!\S)--[a-z-]+', '\n'.join(re.findall(r'^  (\S.*)$', help_text.split("Exit status:")[0], re.M))))


class CommandLine(unittest.TestCase):
    def test_completion_reads_rosbash_when_it_is_first_needed(self):
        script = '. "$1"; declare -F _roscomplete_exe; COMP_WORDS=(rosrun -); COMP_CWORD=1; ' \
                 '_mlic_rosrun rosrun - rosrun; echo "${COMPREPLY[@]}"; complete -p rosrun'
        done = run("bash", "-c", script, "bash", os.path.join(SHARE, "completion.bash"))
        if not os.path.exists("/usr/share/bash-completion/completions/rosbash"):
            self.skipTest("rosbash is not installed")
        self.assertEqual(done.stdout, "--prefix --debug\ncomplete -F _mlic_rosrun rosrun\n", done.stderr)

    def complete(self, *words):
        """What bash offers for the last of these words; `rosbash` where the completion that was there before is asked."""
        script = ('_roscomplete_exe() { COMPREPLY=(rosbash); }; complete -F _roscomplete_exe rosrun; . "$1"; . "$1"; shift; '
                  'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _mlic_rosrun rosrun "${COMP_WORDS[-1]}" "${COMP_WORDS[-2]}"; '
                  'echo "${COMPREPLY[@]}"')
        done = run("bash", "-c", script, "bash", os.path.join(SHARE, "completion.bash"), *words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return set(done.stdout.split())

    def test_version(self):
        for name in [*NAMES, "calibrate_node"]:
            done = program(name, "--version")
            self.assertEqual((done.returncode, done.stdout), (0, f"{name} (MLIC) {VERSION}\n"), done.stderr)

    def test_help(self):
        for name in [*NAMES, "calibrate_node"]:
            done = program(name, "--help")
            self.assertEqual(done.returncode, 0, done.stderr)
            parts = re.fullmatch(r"Usage: rosrun mlic (.*)\n\n.*\nArguments:\n.*\nExit status:\n(.*)\nExample:\n  (.*)\n", done.stdout, re.S)
            self.assertTrue(parts, done.stdout)
            usage, statuses, example = parts.groups()
            self.assertEqual(usage.split()[0], name)
            self.assertLessEqual({"0", "1", "3"}, set(re.findall(r"^  (\d+) ", statuses, re.M)))
            self.assertLessEqual(set(re.findall(r"--[a-z-]+", example)), options_of(done.stdout))
            for line in done.stdout.split("Exit status:")[0].splitlines():
                if line.startswith("      "):
                    self.assertLessEqual(len(line), 80)
                self.assertTrue(line.strip() or line == "", "an option without a description")

    def test_help_says_what_values_are(self):
        text = program("calibrate", "--help").stdout
        for part in ["--rig FILE --bag FILE ... --output DIR", "--matcher {classical,learned}", "(default: classical)",
                     "(default: trajectory)", "(required)", "  4    partial"]:
            self.assertIn(part, text)
        text = " ".join(program("simulate", "--help").stdout.split())
        for part in ["(default: figure_eight)", "(default: 60)", "(default: 4.81)", "--no-guess the rig file"]:
            self.assertIn(part, text)
        self.assertIn("verify (--calibration FILE | --urdf FILE) --bag FILE ...", program("verify", "--help").stdout)

    def test_completion_names_every_option(self):
        for name in NAMES:
            options = options_of(program(name, "--help").stdout)
            self.assertLessEqual({"--help", "--version"}, options)
            self.assertEqual(self.complete("rosrun", "mlic", name, "--"), options)

    def test_completion(self):
        self.assertEqual(self.complete("rosrun", "mlic", ""), set(NAMES))
        self.assertEqual(self.complete("rosrun", "mlic", "cal"), {"calibrate"})
        self.assertEqual(self.complete("rosrun", "mlic", "calibrate", "--bag", "a.bag", "--ou"), {"--output"})
        self.assertEqual(self.complete("rosrun", "mlic", "calibrate", "--matcher", "l"), {"learned"})
        self.assertLessEqual({"tf2", "kalibr"}, self.complete("rosrun", "mlic", "export", "--format", ""))
        self.assertEqual(self.complete("rosrun", "mlic", "calibrate", "--bag", ""), set())
        self.assertEqual(self.complete("rosrun", "--prefix", "gdb", "mlic", "comp"), {"compare"})
        for words in [["rosrun", "ml"], ["rosrun", "tf", ""], ["rosrun", "tf", "tf_echo", "--"], ["rosrun", "--prefix", "mlic"]]:
            self.assertEqual(self.complete(*words), {"rosbash"}, words)

    def test_man_pages(self):
        for name in NAMES:
            path = os.path.join(SHARE, "man1", f"mlic-{name}.1.gz")
            with gzip.open(path, "rt") as file:
                text = file.read().replace("\\-", "-")
            for option in options_of(program(name, "--help").stdout):
                self.assertIn("\n.B ", text)
                self.assertRegex(text, rf"(?m)^\.B (.*, )?{option}\b")
            with gzip.open(os.path.join(SHARE, "man1", "mlic.1.gz"), "rt") as file:
                self.assertIn("mlic\\-" + name, file.read())
            if shutil.which("man"):
                shown = run("man", "--warnings", "-l", path)
                self.assertEqual((shown.returncode, shown.stderr), (0, ""))
                self.assertIn("EXIT STATUS", shown.stdout)


if __name__ == "__main__":
    PROGRAMS, SHARE, VERSION, *NAMES = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
