"""Pictures of replays, charts and maps."""
