"""Never gets as far as a class."""

import time

time.sleep(3600)
