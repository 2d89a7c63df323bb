"""Settings from TOML: what is absent is default, a typo is an error."""

import pytest

from orbitscan.processing.settings import Settings, read_settings
from orbitscan.recorder.exceptions import InvalidOption


def write(tmp_path, text):
    path = tmp_path / "settings.toml"
    path.write_text(text)
    return path


def test_a_file_changes_what_it_names(tmp_path):
    found = read_settings(write(tmp_path, "[ransac]\ntolerance = 3.5\n[pair.refinement]\ncoarse_gate = 2\n"), Settings)
    assert found.ransac.tolerance == 3.5
    assert found.pair.refinement.coarse_gate == 2.0
    assert found.shot == Settings().shot
    assert read_settings(write(tmp_path, ""), Settings) == Settings()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[ransac]\ntolerence = 3\n", "ransac.tolerence"),
        ("[pair.refinement]\ngate = 3\n", "pair.refinement.gate"),
        ("[ransak]\n", "ransak"),
        ("[ransac]\ntolerance = 'wide'\n", "ransac.tolerance"),
        ("ransac = 3\n", "ransac"),
        ("[ransac\n", "no TOML"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, says):
    with pytest.raises(InvalidOption, match=says):
        read_settings(write(tmp_path, text), Settings)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InvalidOption, match="cannot be read"):
        read_settings(tmp_path / "none.toml", Settings)
