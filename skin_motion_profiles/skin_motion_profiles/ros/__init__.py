"""The profile action server and its command-line client."""
