"""What the sections of a page share.

Records of blocks, traces, SVG, rendering to one HTML file.
In: blocks. Out: HTML.
"""
