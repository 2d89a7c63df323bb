"""From a scanner or a mesh to a recording: one MCAP file per session. Knows nothing of processing."""
