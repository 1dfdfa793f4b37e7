"""Public data sets of real machines, converted to the measured CSV."""

from gravcomp.logs.importers.anticogging import anticogging_csv
from gravcomp.logs.importers.emps import emps_csv

IMPORTERS = {"emps": emps_csv, "anticogging": anticogging_csv}
