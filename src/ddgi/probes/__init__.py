"""The probe field: grids, maps, rays, blending and the query."""
