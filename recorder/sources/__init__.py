"""One module per kind of capture; each turns files into lazy Sessions."""
