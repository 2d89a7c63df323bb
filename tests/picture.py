"""A picture of a recording as it opens: `python -m tests.picture results/robot/review.rrd docs/review.png`."""

import sys
import time
from pathlib import Path

from tests.viewer import find_reports, open_viewer


def main(recording: str, picture: str) -> None:
    """Save a screenshot of 1920x1080 and print what any view complains of."""
    with open_viewer(Path(recording)) as viewer:
        time.sleep(2.0)
        viewer.save_screenshot(picture)
        print(f"{picture}: {find_reports(viewer) or 'no view complains'}")


if __name__ == "__main__":
    main(*sys.argv[1:])
