"""What the results of all stages have in common."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.names import rows_of_names

FAILURE_COLUMNS = ["coverage", "model_id", "stage", "reason", "remedy"]
OUTLIERS = ("keep", "snoop", "huber", "tukey")  # what happens to gross errors


class Result(ABC):
    """A frozen result: ``print`` shows its summary."""

    @abstractmethod
    def summary(self) -> str:
        """Return the result as text."""

    def __str__(self) -> str:
        """Return the summary."""
        return self.summary()

    __repr__ = __str__


@dataclass(frozen=True, eq=False)
class Estimates:
    """What was estimated for each model."""

    names: tuple[str, ...]  # of the parameters
    cofactors: np.ndarray  # (n_models, n_parameters, n_parameters)
    # (n_models,): standard error of unit weight; NaN without redundancy
    unit_error: np.ndarray
    is_usable: np.ndarray  # (n_models,)


class ModelResult(Result):
    """A result that holds estimated parameters of each model.

    Its table ``models`` has the columns coverage and model_id.
    """

    @property
    @abstractmethod
    def estimates(self) -> Estimates:
        """What was estimated, in the order of ``models``: Estimates."""

    def cofactor(self, model_id: str, coverage: str | None = None) -> pd.DataFrame:
        """Cofactor matrix of a model's parameters, named on both sides.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        DataFrame
            For unit weight: times the variance of unit weight it is the covariance
            matrix. NaN where the model is not usable.

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages.
        """
        return self._cofactor(row_of_model(self.models, model_id, coverage))

    def covariance(self, model_id: str, coverage: str | None = None) -> pd.DataFrame:
        """Covariance matrix of a model's parameters, named on both sides.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        DataFrame
            NaN where the model has no redundancy, or is not usable.

        Raises
        ------
        TableError
            As :meth:`cofactor`.
        """
        return self._covariance(row_of_model(self.models, model_id, coverage))

    def _cofactor(self, row):
        estimates = self.estimates
        matrix = np.where(estimates.is_usable[row], estimates.cofactors[row], np.nan)
        names = list(estimates.names)
        return pd.DataFrame(matrix, index=names, columns=names)

    def _covariance(self, row):
        return self._cofactor(row) * self.estimates.unit_error[row] ** 2


class FlightsResult(ModelResult):
    """A result for the models of several flights, which may have the same names.

    Its table ``models`` has the column flight as well.
    """

    def cofactor(
        self, model_id: str, coverage: str | None = None, *, flight: str | None = None
    ) -> pd.DataFrame:
        """Cofactor matrix of a model's parameters, named on both sides.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages of a flight have a model of that name.
        flight : {"low_flight", "high_flight"}, optional
            Needed where both flights have one.

        Returns
        -------
        DataFrame
            For unit weight: times the variance of unit weight it is the covariance
            matrix. NaN where the model is not usable.

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages or
            flights.
        SettingsError
            There is no such flight.
        """
        return self._cofactor(self._row(model_id, coverage, flight))

    def covariance(
        self, model_id: str, coverage: str | None = None, *, flight: str | None = None
    ) -> pd.DataFrame:
        """Covariance matrix of a model's parameters, named on both sides.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
        flight : {"low_flight", "high_flight"}, optional
            As for :meth:`cofactor`.

        Returns
        -------
        DataFrame
            NaN where the model has no redundancy, or is not usable.

        Raises
        ------
        TableError, SettingsError
            As :meth:`cofactor`.
        """
        return self._covariance(self._row(model_id, coverage, flight))

    def _row(self, model_id, coverage, flight):
        if flight is not None:
            require_choice("flight", flight, tuple(self.models["flight"].unique()))
        return row_of_model(self.models, model_id, coverage, flight)


class OrientationResult(ModelResult):
    """Orientations; ``models`` has n_points and redundancy as well."""

    @property
    def n_points(self) -> pd.Series:
        """Number of points, Series by model_id."""
        return self._by_model("n_points")

    @property
    def redundancy(self) -> pd.Series:
        """Points beyond five, Series by model_id."""
        return self._by_model("redundancy")

    def _by_model(self, column):
        return self.models.set_index("model_id")[column]


def failures_table(rows) -> pd.DataFrame:
    """Failed models as a table.

    Rows of coverage, model_id, stage, reason, remedy.
    """
    return pd.DataFrame(list(rows), columns=FAILURE_COLUMNS).astype(object)


def row_of_model(models, model_id, coverage=None, flight=None) -> int:
    """Position of a model in a table of models.

    TableError where there is none, or one in each of several coverages or flights and
    ``coverage`` or ``flight`` is left out.
    """
    is_it = (models["model_id"] == str(model_id)).to_numpy()
    if coverage is not None:
        is_it = is_it & (models["coverage"] == str(coverage)).to_numpy()
    if flight is not None:
        is_it = is_it & (models["flight"] == flight).to_numpy()
    places = np.flatnonzero(is_it)
    if len(places) == 1:
        return int(places[0])
    if len(places) == 0:
        raise TableError(
            "there is no such model",
            expected=f"one of {name_some(models['model_id'])}",
            model=model_id,
        )
    flights = models["flight"].iloc[places].unique() if "flight" in models else ()
    if len(flights) > 1:
        raise TableError(
            f"flights {name_some(flights)} each have this model",
            remedy=f'Name the flight as well: flight="{flights[-1]}"',
            model=model_id,
        )
    raise TableError(
        f"coverages {name_some(models['coverage'].iloc[places])} each have this model",
        remedy="Name the coverage as well",
        model=model_id,
    )


def coverages_of_models(models, model_ids):
    """Coverage in which each model was fitted, for models named without one.

    Array of text; "" where there is no such model. TableError where a model was fitted
    in several coverages: one taken for another lies kilometres off.
    """
    is_again = models["model_id"].duplicated().to_numpy()
    known = models[~is_again]
    place = rows_of_names(model_ids, known["model_id"])
    several = rows_of_names(model_ids, models["model_id"][is_again].unique())
    if (several >= 0).any():
        model_id = np.asarray(model_ids, dtype=object)[np.argmax(several >= 0)]
        of_model = models["coverage"][(models["model_id"] == model_id).to_numpy()]
        raise TableError(
            f"coverages {name_some(of_model)} each have this model",
            expected="a column coverage, which says of each point which of them is "
            "meant",
            remedy="Add it to the table",
            model=model_id,
        )
    coverage = known["coverage"].to_numpy(dtype=object)
    return np.where(place >= 0, coverage[place], "")
