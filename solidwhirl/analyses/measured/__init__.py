"""What was measured on a machine at rest, beside what is computed: the hammer test.

Universal files and CSV files in; functions and modes with the names of the sensors out.
"""
