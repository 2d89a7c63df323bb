"""Session <-> .mcap: Foxglove protobuf messages, zstd, that open in Foxglove and Rerun with nothing converted.

Every message is a chunk of its own and is flushed: a writer that dies loses nothing it had finished, a flipped bit
costs one view, poses are read without decompressing clouds. A file with an intact summary is read by its index; a cut
or damaged one is searched for the chunks that are still whole. What metadata say is checked by a CRC of their own.
"""

from orbitscan.recorder.mcap_file.messages import POINTS_TOPIC, POSES_TOPIC
from orbitscan.recorder.mcap_file.metadata import FORMAT_VERSION
from orbitscan.recorder.mcap_file.reading import read
from orbitscan.recorder.mcap_file.unfinished import still_being_written
from orbitscan.recorder.mcap_file.writing import write

__all__ = ["FORMAT_VERSION", "POINTS_TOPIC", "POSES_TOPIC", "read", "still_being_written", "write"]
