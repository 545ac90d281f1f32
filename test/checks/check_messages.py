#!/usr/bin/python3
"""Fails on a message of a verdict that docs/troubleshooting.md does not list: reasons, problems, failures of checks and
warnings, as the code writes them.

usage: check_messages.py REPOSITORY | --self-test

A message is what a statement `... .failure = "..."`, `problems.push_back("...")`, `reasons.push_back("...")` or
`warnings.push_back("...")` says, or the format that fills the variable which such a statement is given. It is listed
where four words in a row of it stand in the first cell of a row of the page; shorter ones stand there whole. Numbers and
names, which differ from drive to drive, part the words.
"""

import pathlib
import re
import sys

STATEMENT = re.compile(r'(?:\.failure\s*=|(?:problems|reasons|warnings)\.push_back\()')
LITERAL = re.compile(r'"((?:[^"\\]|\\.)*)"')
WORDS = 4  # in a row


def statements(text):
    """Each statement that gives a message, from its keyword to its semicolon outside of strings, and its place."""
    for found in STATEMENT.finditer(text):
        end = found.end()
        while end < len(text) and text[end] != ';':
            literal = LITERAL.match(text, end) if text[end] == '"' else None
            end = literal.end() if literal else end + 1
        yield found.start(), text[found.end():end]


def format_before(text, place, variable):
    """The format of the last snprintf into the variable before a place; nothing where there is none."""
    calls = [call for call in re.finditer(r'snprintf\(\s*' + variable + r'\b', text) if call.start() < place]
    return text[calls[-1].start():text.index(';', calls[-1].start())] if calls else ''


def runs(literals):
    """Words in a row between numbers, names and marks."""
    parts = []
    for literal in literals:
        literal = re.sub(r'\\.|%[-+0-9.*]*[a-z]+|%%', '\0', literal)
        parts.append(literal)
    # Adjacent literals are one string; whatever stands between them in the statement is a value.
    return [words for words in (re.findall(r"[A-Za-z_']+", part) for part in re.split('\0|[:;(),]', '\1'.join(parts))) if words]


def messages(text):
    """The runs of words of each message of a source file, with its line."""
    for place, statement in statements(text):
        if not LITERAL.search(statement):
            variable = re.search(r'\b([a-z_]+)\b[^a-z_]*$', statement)
            statement = format_before(text, place, variable.group(1)) if variable else ''
        # Literals that follow each other directly are joined.
        joined = re.sub(r'"\s*"', '', statement)
        found = runs(LITERAL.findall(joined))
        if found:
            yield text.count('\n', 0, place) + 1, found


def normal(words):
    return ' ' + ' '.join(word.lower() for word in words) + ' '


def is_listed(found, cells):
    for words in found:
        length = min(WORDS, len(words))
        if length < WORDS and any(len(other) >= WORDS for other in found):
            continue
        for begin in range(len(words) - length + 1):
            part = normal(words[begin:begin + length])
            if any(part in cell for cell in cells):
                return True
    return False


def cells_of(page):
    return [normal(re.findall(r"[A-Za-z_']+", row.split('|')[1])) for row in page.splitlines() if row.startswith('|')]


def unlisted(sources, page):
    cells = cells_of(page)
    for name, text in sources:
        for line, found in messages(text):
            if not is_listed(found, cells):
                yield f'{name}:{line}: docs/troubleshooting.md has no row for: ' + ' / '.join(' '.join(words) for words in found)


def self_test():
    page = '| message | cause |\n|---|---|\n| NAME: its photos do not match the LiDAR map | fog |\n| saturated | x |\n'
    listed = 'check.failure = name + ": its photos do not match " "the LiDAR map; it rests on tracks";'
    by_format = 'std::snprintf(line, sizeof(line), "%s: its photos do not match", name);\nresult.problems.push_back(line);'
    other = 'result->reasons.push_back("the moon; was full and bright");'
    short = 'warnings.push_back(topic + ": saturated");'
    assert not list(unlisted([('a.cc', listed + by_format + short)], page))
    found = list(unlisted([('a.cc', '\n' + other)], page))
    assert len(found) == 1 and found[0].startswith('a.cc:2:'), found
    assert list(unlisted([('a.cc', short.replace('saturated', 'asleep'))], page))


def main():
    if sys.argv[1:] == ['--self-test']:
        self_test()
        return
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    root = pathlib.Path(sys.argv[1])
    sources = [(str(path.relative_to(root)), path.read_text()) for path in sorted((root / 'src').rglob('*.cc'))]
    missing = list(unlisted(sources, (root / 'docs/troubleshooting.md').read_text()))
    if missing:
        sys.exit('\n'.join(missing))
    count = sum(len(list(messages(text))) for _, text in sources)
    print(f'check_messages.py: {count} messages of verdicts, each has its row in docs/troubleshooting.md')


if __name__ == '__main__':
    main()
