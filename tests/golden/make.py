"""Makes the golden labels anew: a JSON file for each take of `golden_takes`, with labels, confidences and reasons.

    python tests/golden/make.py [NAME ...]

Run it again only after a change that is meant to alter labels, when what altered has been looked at take by take and
measured on real recordings; the change is then said in CHANGELOG.md, under "Changes that can alter labels". Never run
it to make a refactoring pass: that is what the files are there to stop.
"""

import sys

from golden_takes import CASES, FOLDER, as_text, labelled

if __name__ == "__main__":
    for name in sys.argv[1:] or CASES:
        (FOLDER / f"{name}.json").write_text(as_text(labelled(name)), encoding="utf-8")
        print(f"{name}: {len(labelled(name)['trajectories'])} trajectories")
