"""Files of a run: its folder, pictures' index, VTK and surfaces.

Complete or recognisably not, checkable later.
In: arrays and documents. Out: files with checksums.
"""
