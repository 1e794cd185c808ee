"""Run time against error beside other engines, and maps of where digits are lost.

Every file opens with its question and ends with its answer. `python -m benchmarks` runs all of
them and writes tables and pictures to `benchmarks/results`.
"""
