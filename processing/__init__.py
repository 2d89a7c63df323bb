"""From a recording to results: `pipeline` is the method on one page."""
