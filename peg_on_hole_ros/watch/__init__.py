"""The live page of a running node: its topics, thinned to frames, sent to browsers."""
