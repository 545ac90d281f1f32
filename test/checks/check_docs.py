#!/usr/bin/python3
"""Fails where the documents point to something that is not there.

usage: check_docs.py REPOSITORY

Links of README and docs/*.md must lead to files and headings that exist, file names in backquotes must be files, and
sections of docs/method.md that the sources cite must be in it.
"""

import pathlib
import re
import sys

FENCED = re.compile(r'```.*?```', re.S)
LINK = re.compile(r'\]\(([^)\s]+)\)')
FILE = re.compile(r'`((?:\w+/)+\w+\.(?:h|cc|py|sh))`')
# A citation may be broken between lines of a comment.
CITATION = re.compile(r'docs/method\.md,\s+(?://\s+)?sections?\s+(?://\s+)?([\d.]*\d)(?:\s+(?:and|to)\s+([\d.]*\d))?')
PLACES = ('', 'src', 'src/mlic_core')  # that names in backquotes may start from


def anchors(page):
    """The anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r'^#+ (.*)$', FENCED.sub('', page.read_text(encoding='utf-8')), re.M)
    return {re.sub(r'[^\w\- ]', '', heading.lower()).replace(' ', '-') for heading in headings}


def faults_of_page(root, page):
    text = FENCED.sub('', page.read_text(encoding='utf-8'))
    for link in LINK.findall(text):
        if '://' in link:
            continue
        name, _, anchor = link.partition('#')
        target = page.parent / name if name else page
        if not target.exists():
            yield f'{page.relative_to(root)}: link to {link}, which does not exist'
        elif anchor and anchor not in anchors(target):
            yield f'{page.relative_to(root)}: {link}: no such heading'
    for name in FILE.findall(text):
        if not any((root / place / name).exists() for place in PLACES):
            yield f'{page.relative_to(root)}: no file {name}'


def faults_of_citations(root):
    sections = set(re.findall(r'^#+ (\d[\d.]*?)\.? ', (root / 'docs/method.md').read_text(encoding='utf-8'), re.M))
    for folder in ('src', 'test', 'benchmark'):
        for path in sorted((root / folder).rglob('*')):
            if path.suffix not in ('.cc', '.h'):
                continue
            for cited in CITATION.findall(path.read_text(encoding='utf-8')):
                for section in filter(None, cited):
                    if section not in sections:
                        yield f'{path.relative_to(root)}: docs/method.md has no section {section}'


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = [root / 'README.md', root / 'CHANGELOG.md', *sorted((root / 'docs').glob('*.md'))]
    faults = [fault for page in pages for fault in faults_of_page(root, page)] + list(faults_of_citations(root))
    print('\n'.join(faults) if faults else f'{len(pages)} pages: every link, file and cited section is there')
    sys.exit(1 if faults else 0)


if __name__ == '__main__':
    main()
