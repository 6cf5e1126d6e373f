"""Rays: what they find."""
