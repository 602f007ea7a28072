from painleve_sym.present.animation import Animation as Animation
from painleve_sym.present.figure_of_contrast import contrast_figure as contrast_figure
from painleve_sym.present.figure_of_fit import fit_figure as fit_figure
from painleve_sym.present.figure_of_map import map_figure as map_figure
from painleve_sym.present.figure_of_outcome import outcome_figure as outcome_figure
from painleve_sym.present.figure_of_risk import risk_figure as risk_figure
from painleve_sym.present.figure_of_risk_trajectory import (
    risk_trajectory_figure as risk_trajectory_figure,
)
from painleve_sym.present.figure_of_sensitivity import sensitivity_figure as sensitivity_figure
from painleve_sym.present.figure_of_trajectory import trajectory_figure as trajectory_figure
from painleve_sym.present.report import write_report as write_report
from painleve_sym.present.style import Look as Look
from painleve_sym.present.style import write_figure as write_figure
