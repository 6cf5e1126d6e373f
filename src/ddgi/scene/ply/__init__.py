"""PLY files: header, tables, and what becomes of them."""
