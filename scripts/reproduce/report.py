"""What the scripts of this folder print."""

import sys


def short(value):
    return f"{value:.1e}".replace("e-0", "e-")


def table(title, head, rows):
    print(f"\n**{title}**\n\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        print(f"| {' | '.join(str(cell) for cell in row)} |")
    sys.stdout.flush()


def verdict(holds, words):
    print(f"- {'confirmed' if holds else 'contradicted'}: {words}")
