"""Record what every golden question is answered today.

python -m tests.golden.freeze [--source NAME] [--limit SECONDS]
"""

from __future__ import annotations

import argparse
import time

from .questions import SOURCES
from .record import answered, file_of, write


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Record what every golden question is answered today."
    )
    parser.add_argument("--source", choices=SOURCES)
    parser.add_argument("--limit", type=int, default=60, metavar="SECONDS", help="of the processor")
    options = parser.parse_args()
    for source in [options.source] if options.source else SOURCES:
        started = time.process_time()
        entries = {
            question.name: answered(question, options.limit) for question in SOURCES[source]()
        }
        write(source, entries)
        size, seconds = file_of(source).stat().st_size / 1e6, time.process_time() - started
        print(f"{source:<16}{len(entries):>6} questions{size:8.2f} MB{seconds:8.1f} s", flush=True)


if __name__ == "__main__":
    main()
