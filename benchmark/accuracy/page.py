"""Sections of a page that a program writes, between two markers."""

import pathlib

PAGE = pathlib.Path(__file__).resolve().parent.parent.parent / 'docs/benchmark.md'


def replace_section(page, begin, end, lines):
    """Replaces what stands between the markers, or adds it and them at the end."""
    text = '\n'.join([begin, *lines, end])
    old = page.read_text(encoding='utf-8') if page.exists() else '# Benchmarks\n'
    if begin in old and end in old:
        new = old[:old.index(begin)] + text + old[old.index(end) + len(end):]
    else:
        new = old.rstrip('\n') + '\n\n' + text + '\n'
    page.write_text(new, encoding='utf-8')
