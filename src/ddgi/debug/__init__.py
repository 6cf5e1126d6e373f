"""Pictures of what the field does: where probes stand, what they hold, which of them light a pixel."""
