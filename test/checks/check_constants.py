#!/usr/bin/python3
"""Counts constants and default options whose comment does not state where the value comes from (docs/conventions.md).

usage: check_constants.py SOURCE_DIRECTORY [--most N | --list] | --self-test

Looked at: numbers named k[A-Z]... and fields with a numeric default of structs named ...Options, in all of src.
The comment on the line, or the one right above, says `from: KIND`, with KIND one of
    derivation   follows from a formula, a distribution or other values; the comment gives it
    paper        a publication, named
    measured     tried on data, which the comment names
    standard     a format, an interface or a data sheet
    definition   part of what the program promises, or of the simulated world
    structural   no tuning: sizes, places of columns, factors of units, how a picture looks
    guard        a cap on time, memory or iterations, or a limit between things that lie far apart
    judgement    somebody's choice, not measured: counts as not stated
`Constants of this file, from: KIND` holds for all constants of a file that do not say more. Pure factors of degrees and
radians need no comment.
--most N: exit status 1 when more than N are without an origin. --list: prints those.
"""

import collections
import pathlib
import re
import sys
import tempfile

STATED = {'derivation', 'paper', 'measured', 'standard', 'definition', 'structural', 'guard'}
NUMBER = r'(?:double|float|int|unsigned|std::size_t|std::u?int\w+_t|TimeNs|std::chrono::\w+)'
CONSTANT = re.compile(r'^\s*(?:static |inline )*(?:constexpr|const) (?:std::array<)*' + NUMBER +
                      r'\b[^=({]*?\b(?P<name>k[A-Z]\w*)(?:\[[^\]]*\])*\s*[={(](?P<value>.*)')
FIELD = re.compile(r'^\s*' + NUMBER + r' (?P<name>[a-z]\w*)\s*[={]\s*(?P<value>[-\d].*)')
ORIGIN = re.compile(r'\bfrom: (\w+)')
OF_FILE = re.compile(r'Constants of this file, from: (\w+)')
UNIT = re.compile(r'^\s*(180(\.0)? / M_PI|M_PI / 180(\.0f?)?);')

Constant = collections.namedtuple('Constant', 'path line name kind')


def comment_of(lines, at):
    """The comment on line `at` and the following lines of its statement, or the one right above."""
    own, end = lines[at].partition('//')[2], at
    while ';' not in lines[end].partition('//')[0] and end + 1 < len(lines):
        end += 1
        own += ' ' + lines[end].partition('//')[2]
    # A comment may go on below the statement it stands beside.
    while own and end + 1 < len(lines) and re.match(r'^\s{8,}//', lines[end + 1]):
        end += 1
        own += ' ' + lines[end].strip().lstrip('/')
    if ORIGIN.search(own):
        return own
    block, above = [], at - 1
    while above >= 0 and lines[above].strip().startswith('//'):
        block.insert(0, lines[above].strip().lstrip('/'))
        above -= 1
    return ' '.join(block)


def option_lines(lines):
    """Numbers of the lines inside structs named ...Options."""
    inside, depth = set(), 0
    for number, line in enumerate(lines):
        code = line.partition('//')[0]
        if depth == 0 and re.match(r'^\s*struct \w*Options\b[^;]*\{', code):
            depth = code.count('{') - code.count('}')
            continue
        if depth > 0:
            inside.add(number)
            depth += code.count('{') - code.count('}')
    return inside


def constants_of(path):
    """All constants and default options of one file; kind None without an origin."""
    text = path.read_text(encoding='utf-8')
    lines = text.splitlines()
    of_file = OF_FILE.search(text)
    options = option_lines(lines)
    found = []
    for number, line in enumerate(lines):
        match = CONSTANT.match(line)
        if not match and number in options:
            match = FIELD.match(line)
        if not match:
            continue
        origin = ORIGIN.search(comment_of(lines, number)) or of_file
        kind = 'structural' if UNIT.match(match.group('value')) else origin.group(1) if origin else None
        found.append(Constant(path, number + 1, match.group('name'), kind))
    return found


def check(source):
    """All constants below the directory `source`."""
    return [constant for path in sorted(source.rglob('*')) if path.suffix in {'.h', '.cc'}
            for constant in constants_of(path)]


def self_test():
    """Plants constants with and without an origin and sees which count as stated."""
    planted = [
        ('constexpr double kA = 3.0;  // from: derivation, 0.3 % lie beyond', 1, 1),
        ('// from: measured, drive X\nconstexpr double kA = 3.0;\nconstexpr int kB = 4;', 2, 1),
        ('// from: measured, drive X\n\nconstexpr double kA = 3.0;', 1, 0),
        ('// from: measured, drive X\nconstexpr double kA = 3.0;\n// Of b.\nconstexpr int kB = 4;', 2, 1),
        ('constexpr double kA = 3.0;  // from: judgement', 1, 0),
        ('constexpr double kA = 3.0;  // from: somewhere', 1, 0),
        ('constexpr double kA = 3.0;  // m', 1, 0),
        ('constexpr double kA =\n    3.0;  // m; from: standard', 1, 1),
        ('constexpr double kDegree = M_PI / 180.0;', 1, 1),
        ('constexpr char kA[] = "a";\nconst std::string kB = "3";', 0, 0),
        ('struct AOptions {\n  double a = 3.0;\n  int b = 4;  // from: guard, time\n  bool c = true;\n};\n'
         'struct Other {\n  double d = 3.0;\n};', 2, 1),
        ('// Constants of this file, from: structural.\n\nconstexpr int kA = 3;\n// B.\nconstexpr int kB = 4;', 2, 2),
    ]
    for text, expected, stated in planted:
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / 'a.cc').write_text(text + '\n')
            found = check(pathlib.Path(folder))
            assert len(found) == expected, f'{text}: found {found}'
            assert sum(constant.kind in STATED for constant in found) == stated, f'{text}: found {found}'
    print(f'check_constants.py: {len(planted)} planted files judged rightly')


def main():
    if sys.argv[1:] == ['--self-test']:
        self_test()
        return
    if len(sys.argv) not in (2, 3, 4):
        sys.exit(__doc__)
    found = check(pathlib.Path(sys.argv[1]))
    if not found:
        sys.exit(f'check_constants.py: no constant in {sys.argv[1]}')
    without = [constant for constant in found if constant.kind not in STATED]
    if '--list' in sys.argv:
        print('\n'.join(f'{constant.path}:{constant.line}: {constant.name}' for constant in without))
    kinds = collections.Counter(constant.kind for constant in found)
    print(f'check_constants.py: {len(found)} constants and default options, {len(without)} without a stated origin (' +
          ', '.join(f'{kinds[kind]} {kind}' for kind in sorted(STATED)) + f', {kinds["judgement"]} judgement)')
    if '--most' in sys.argv and len(without) > int(sys.argv[sys.argv.index('--most') + 1]):
        sys.exit('check_constants.py: more than the limit: say in the comment of the new ones where they come from '
                 '(`from: KIND`, docs/conventions.md); --list names them all')


if __name__ == '__main__':
    main()
