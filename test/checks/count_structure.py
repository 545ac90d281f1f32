#!/usr/bin/python3
"""Prints sizes of the code: rooms, units, includes between them, lengths of files and functions, parameter lists.

usage: count_structure.py SOURCE_DIRECTORY [--longest-file N] [--longest-function N] [--most-parameters N] | --self-test

Functions are found by matching braces after comments and strings are taken out, parameters by commas at depth one;
lambdas count to their function. With a limit: exit status 1 when something exceeds it. Directions of includes and
circles: check_layers.py.
"""

import argparse
import collections
import pathlib
import re
import statistics
import sys

SUFFIXES = {'.h', '.cc'}
INCLUDE = re.compile(r'^\s*#\s*include\s*"(mlic_\w+/[^"]+)"', re.MULTILINE)
# No functions, though a bracket and a brace follow: control flow and type definitions.
NOT_A_FUNCTION = {'if', 'for', 'while', 'switch', 'catch', 'return', 'sizeof', 'alignas', 'decltype', 'static_assert'}

Function = collections.namedtuple('Function', 'path name lines parameters')


def blank(text):
    """The text with comments, strings and preprocessor lines as blanks, line breaks kept."""
    def spaces(match):
        return re.sub(r'[^\n]', ' ', match.group(0))
    text = re.sub(r'R"(\w*)\(.*?\)\1"', spaces, text, flags=re.DOTALL)
    literal = r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\''
    text = re.sub(literal, spaces, text, flags=re.DOTALL)
    return re.sub(r'^\s*#[^\n]*(?:\\\n[^\n]*)*', spaces, text, flags=re.MULTILINE)


def closing(text, start, pair):
    """Place of the bracket that closes the one at `start`; -1 without."""
    depth = 0
    for place in range(start, len(text)):
        if text[place] == pair[0]:
            depth += 1
        elif text[place] == pair[1]:
            depth -= 1
            if depth == 0:
                return place
    return -1


def parameter_count(inner):
    depth, count = 0, 1 if inner.strip() and inner.strip() != 'void' else 0
    for letter in inner:
        depth += letter in '(<[{'
        depth -= letter in ')>]}'
        count += letter == ',' and depth == 0
    return count


def body_of(text, place):
    """Where the body of a function begins whose parameters end before `place`; -1 when it is declared or called."""
    place = re.compile(r'(?:\s|const\b|noexcept\b|override\b|final\b|&|->\s*[\w:<>,*&]+)*').match(text, place).end()
    if text[place:place + 1] == ':' and text[place:place + 2] != '::':
        item = re.compile(r'\s*[\w:<>, ]+?\s*(?=[({])')
        while True:  # initialisers, up to the one that no comma follows
            head = item.match(text, place + 1)
            if not head:
                return -1
            place = closing(text, head.end(), '()' if text[head.end()] == '(' else '{}') + 1
            place += len(re.match(r'\s*', text[place:place + 200]).group(0))
            if place <= 0 or text[place:place + 1] != ',':
                break
    return place if text[place:place + 1] == '{' else -1


def functions_of(path, text):
    """Functions defined in the blanked text, outermost ones only."""
    found, place = [], 0
    head = re.compile(r'([A-Za-z_~][\w:~]*(?:<[^<>;{}]*>)?|operator\S+)\s*\(')
    while True:
        match = head.search(text, place)
        if not match:
            return found
        place = match.end()
        end = closing(text, match.end() - 1, '()')
        if end < 0 or match.group(1) in NOT_A_FUNCTION:
            continue
        start = body_of(text, end + 1)
        last = closing(text, start, '{}') if start >= 0 else -1
        if last < 0:
            continue
        lines = text.count('\n', match.start(), last) + 1
        found.append(Function(path, match.group(1), lines, parameter_count(text[match.end():end])))
        place = last


def room_of(parts):
    """mlic_core/camera for mlic_core/camera/tracks/patch.cc."""
    return '/'.join(parts[:2]) if parts[0] in ('mlic_core', 'mlic_ros') and len(parts) > 2 else parts[0]


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def measure(source):
    files, functions, rooms, edges = {}, [], collections.Counter(), set()
    for path in sorted(source.rglob('*')):
        if path.suffix not in SUFFIXES or not path.is_file():
            continue
        text = path.read_text(encoding='utf-8')
        parts = path.relative_to(source).parts
        files[path] = text.count('\n')
        rooms[room_of(parts)] += files[path]
        functions += functions_of(path, blank(text))
        for header in INCLUDE.findall(text):
            used = room_of(tuple(header.split('/')))
            if used != room_of(parts):
                edges.add((room_of(parts), used))
    return files, functions, rooms, edges


def self_test():
    """Functions of all shapes, and what only looks like one."""
    text = blank('''
        namespace a {
        int Free(int a, std::map<int, int> b) {
          if (a > 0) { return Call(a, "{(", '{'); }  // {
          return 0;
        }
        Class::Class(int a) : a_(a), b_{a} {}
        double Class::Get() const { return a_; }
        struct S { int x = 3; void Do(int, int, int) noexcept { [&](int y) { Use(y); }(1); } };
        int Declared(int, int);
        }''')
    found = [(f.name, f.lines, f.parameters) for f in functions_of(None, text)]
    assert found == [('Free', 4, 2), ('Class::Class', 1, 1), ('Class::Get', 1, 0), ('Do', 1, 3)], found
    print('count_structure.py: 4 planted functions found')


def main():
    if sys.argv[1:] == ['--self-test']:
        self_test()
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('source', type=pathlib.Path)
    parser.add_argument('--longest-file', type=int)
    parser.add_argument('--longest-function', type=int)
    parser.add_argument('--most-parameters', type=int)
    arguments = parser.parse_args()
    files, functions, rooms, edges = measure(arguments.source)
    if not files:
        sys.exit(f'count_structure.py: no source file in {arguments.source}')
    total = sum(files.values())
    room, lines = rooms.most_common(1)[0]
    print(f'{len(files)} files of {total} lines in {len(rooms)} rooms, {len(edges)} includes between rooms')
    print(f'largest room: {room}, {lines} lines, {100 * lines / total:.0f} %')
    for name, sizes in [('files', list(files.values())), ('functions', [f.lines for f in functions])]:
        print(f'{len(sizes)} {name}: median {statistics.median(sizes):.0f}, p95 {percentile(sizes, 0.95)}, '
              f'longest {max(sizes)} lines')
    parameters = collections.Counter(function.parameters for function in functions)
    print('parameters: ' + ', '.join(f'{count} functions take {number}' for number, count in sorted(parameters.items())
                                     if number >= 6))
    faults = [f'{path}: {lines} lines' for path, lines in files.items()
              if arguments.longest_file and lines > arguments.longest_file]
    faults += [f'{f.path}: {f.name}: {f.lines} lines' for f in functions
               if arguments.longest_function and f.lines > arguments.longest_function]
    faults += [f'{f.path}: {f.name}: {f.parameters} parameters' for f in functions
               if arguments.most_parameters and f.parameters > arguments.most_parameters]
    if faults:
        sys.exit('\n'.join(faults) + f'\ncount_structure.py: {len(faults)} beyond the limits')


if __name__ == '__main__':
    main()
