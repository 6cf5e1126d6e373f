"""Wavefront OBJ files with MTL materials, to the dictionary that Mitsuba's parser takes.

Source: Wavefront, Advanced Visualizer, appendix B1 (OBJ) and "MTL material format" (1995). Shapes are
the file's objects and groups, one for each material in them.
"""
