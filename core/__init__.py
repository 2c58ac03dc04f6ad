"""The science: arrays and frozen dataclasses in, frozen dataclasses out; knows no queue, database or command line."""
