"""What a scene holds, what its cameras see, and what of it will spoil the light."""
