"""Recordings damaged at random, through the commands: nothing breaks, and what is whole comes out."""
