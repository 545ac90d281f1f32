#!/usr/bin/python3
"""Makes man pages and bash completion of what the programs print for --help.

usage: command_line_files.py VERSION OUTPUT PROGRAM...

Writes OUTPUT/man1/mlic.1.gz, OUTPUT/man1/mlic-NAME.1.gz for each program, and OUTPUT/completion.bash.
"""

import gzip
import pathlib
import re
import subprocess
import sys

COMPLETION = r'''# Completion of the options of MLIC's programs after `rosrun mlic`; made by cmake/command_line_files.py. All else that
# rosrun takes is left to the completion that was there before, which is rosbash's.

_mlic_programs() { echo "@PROGRAMS@"; }

_mlic_options() {
  case $1 in
@OPTIONS@
  esac
}

# The choices of an option that takes one of a few words.
_mlic_choices() {
  case "$1 $2" in
@CHOICES@
  esac
}

# _mlic_rosrun COMMAND WORD PREVIOUS, as bash calls it.
_mlic_rosrun() {
  local at=1 choices
  COMPREPLY=()
  while [[ ${COMP_WORDS[at]} == -* && $at -lt $COMP_CWORD ]]; do
    [[ ${COMP_WORDS[at]} == -p || ${COMP_WORDS[at]} == --prefix ]] && at=$((at + 1))
    at=$((at + 1))
  done
  if [[ ${COMP_WORDS[at]} != mlic || $COMP_CWORD -le $at ]]; then
    _mlic_other_rosrun "$@"
    return 0
  fi
  if [[ $COMP_CWORD -eq $((at + 1)) ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_mlic_programs)" -- "$2")
    return 0
  fi
  choices=$(_mlic_choices "${COMP_WORDS[at + 1]}" "$3")
  if [[ -n $choices ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$2")
  elif [[ $2 == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_mlic_options "${COMP_WORDS[at + 1]}")" -- "$2")
  else
    compopt -o default 2>/dev/null
  fi
  return 0
}

# What completed rosrun before; rosbash is read when it is first asked for.
_mlic_other_rosrun() {
  if [[ -z $_mlic_rosrun_before && -r /usr/share/bash-completion/completions/rosbash ]]; then
    . /usr/share/bash-completion/completions/rosbash
    _mlic_take_rosrun
  fi
  [[ -n $_mlic_rosrun_before ]] && "$_mlic_rosrun_before" "$@"
}

_mlic_take_rosrun() {
  local found
  found=$(complete -p rosrun 2>/dev/null | sed -n 's/.* -F \([^ ]*\) .*/\1/p')
  [[ $found == _mlic_rosrun ]] || _mlic_rosrun_before=$found
  complete -F _mlic_rosrun rosrun
}

_mlic_take_rosrun
'''


class Help:
    """The parts of what a program prints for --help (src/mlic_ros/programs/help_text.h)."""

    def __init__(self, program):
        self.name = program.name
        text = subprocess.run([program, '--help'], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout
        head, arguments, statuses, example = re.fullmatch(
            r'(.*)\nArguments:\n(.*)\nExit status:\n(.*)\nExample:\n(.*)', text, re.S).groups()
        usage, self.summary = (' '.join(part.split()) for part in head.split('\n\n', 1))
        self.usage = usage.replace('Usage: ', '', 1)
        self.arguments = [(name, ' '.join(description.split()))
                          for name, description in re.findall(r'^  (\S.*)\n((?:      .*\n)+)', arguments, re.M)]
        self.statuses = re.findall(r'^  (\d+) +(.*)$', statuses, re.M)
        self.example = example.strip()

    def options(self):
        return [word for name, _ in self.arguments for word in re.findall(r'(?<!\S)--[\w-]+', name)]

    def choices(self):
        """option -> the words that it takes."""
        found = ((re.search(r'(--[\w-]+) \{(.*)\}', name)) for name, _ in self.arguments)
        return {match.group(1): match.group(2).replace(',', ' ') for match in found if match}


def escaped(text):
    """Text as troff takes it: a period or quote at the start of a line is a request, - a hyphen."""
    text = text.replace('\\', r'\e').replace('-', r'\-')
    return re.sub(r'^([.\'])', r'\&\1', text, flags=re.M)


def page(name, version, sections):
    text = f'.TH {name.upper()} 1 "" "MLIC {version}" "MLIC"\n.ad l\n'
    return text + ''.join(f'.SH {title}\n{body.strip()}\n' for title, body in sections)


def tagged(entries):
    return ''.join(f'.TP\n.B {escaped(tag)}\n{escaped(text)}\n' for tag, text in entries)


def program_page(program, version):
    example = '.nf\n' + escaped(program.example) + '\n.fi\n'
    return page(f'mlic-{program.name}', version, [
        ('NAME', f'mlic\\-{escaped(program.name)} \\- {escaped(program.summary.rstrip("."))}'),
        ('SYNOPSIS', '.B ' + escaped(program.usage)),
        ('DESCRIPTION', escaped(program.summary)),
        ('ARGUMENTS', tagged(program.arguments)),
        ('EXIT STATUS', tagged(program.statuses)),
        ('EXAMPLE', example),
        ('SEE ALSO', '.BR mlic (1)')])


def overview_page(programs, version):
    return page('mlic', version, [
        ('NAME', 'mlic \\- calibration of LiDARs, cameras and IMU from one recorded drive'),
        ('SYNOPSIS', '.B rosrun mlic\n.I PROGRAM\n[ARGUMENT ...]'),
        ('PROGRAMS', tagged((program.name, program.summary) for program in programs)),
        ('SEE ALSO', ',\n'.join(f'.BR mlic\\-{escaped(program.name)} (1)' for program in programs))])


def completion(programs):
    options = [f'    {program.name}) echo "{" ".join(program.options())}" ;;' for program in programs]
    choices = [f'    "{program.name} {option}") echo "{words}" ;;'
               for program in programs for option, words in program.choices().items()]
    return (COMPLETION.replace('@PROGRAMS@', ' '.join(program.name for program in programs))
            .replace('@OPTIONS@', '\n'.join(options)).replace('@CHOICES@', '\n'.join(choices)))


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    version, output = sys.argv[1], pathlib.Path(sys.argv[2])
    programs = [Help(pathlib.Path(program)) for program in sys.argv[3:]]
    (output / 'man1').mkdir(parents=True, exist_ok=True)
    pages = {f'mlic-{program.name}': program_page(program, version) for program in programs}
    pages['mlic'] = overview_page(programs, version)
    for name, text in pages.items():
        (output / 'man1' / f'{name}.1.gz').write_bytes(gzip.compress(text.encode('utf-8'), mtime=0))
    (output / 'completion.bash').write_text(completion(programs), encoding='utf-8')


main()
