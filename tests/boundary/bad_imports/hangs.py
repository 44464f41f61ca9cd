"""Module that misbehaves when it is imported."""

import time

time.sleep(600)
