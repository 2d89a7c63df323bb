"""Results as they are read back, with nothing in them but what a test puts there."""

from pathlib import Path

from orbitscan.processing.results.folder import FORMAT_VERSION, InputFacts, Results, ResultsFolder, SessionFacts


def make_results(name="blob", category=None, views=4, **fields):
    """The results of a session; `fields` are those of Results."""
    names = tuple(f"view_{view:03d}" for view in range(views))
    empty = {
        "format_version": FORMAT_VERSION,
        "key": {},
        "session": SessionFacts(name, category, None, 9, tuple(range(views)), names),
        "input": InputFacts(f"{name}.mcap", "", None),
        "settings": {},
        "versions": {},
        "seed": 0,
        "classification": None,
        "origin": 0,
        "reconstruction": {},
        "turntable": None,
        "coverage": None,
        "model": None,
    }
    return Results(**empty | fields)


def make_folder(name, seconds, **fields):
    """A results folder as read, that lies nowhere."""
    return ResultsFolder(Path(name), make_results(name, **fields), seconds)
