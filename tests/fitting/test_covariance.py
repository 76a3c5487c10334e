"""The cluster-robust covariance against its definition, written out with n × n matrices."""

import numpy as np
import pytest
from scipy.linalg import sqrtm

from pam_ident.fitting.covariance import covariance


def problem(seed=2, n=90, k=3, groups=9):
    rng = np.random.default_rng(seed)
    matrix = np.column_stack([np.ones(n), np.linspace(0, 1, n), rng.standard_normal(n)]) * [1.0, 50.0, 1e-3]
    cluster = np.repeat(np.arange(groups), n // groups)
    residual = rng.standard_normal(n) + rng.standard_normal(groups)[cluster]
    residual -= matrix @ np.linalg.lstsq(matrix, residual, rcond=None)[0]
    return matrix, residual, cluster


def by_definition(matrix, residual, cluster, contrast):
    """CR2 variance of a contrast and its Satterthwaite freedom (Bell & McCaffrey 2002), no shortcuts."""
    bread = np.linalg.inv(matrix.T @ matrix)
    annihilator = np.eye(len(matrix)) - matrix @ bread @ matrix.T
    variance, vectors = 0.0, []
    for g in np.unique(cluster):
        here = cluster == g
        adjust = np.real(np.linalg.inv(sqrtm(annihilator[np.ix_(here, here)])))
        pull = adjust @ matrix[here] @ bread @ contrast
        variance += float(pull @ residual[here]) ** 2
        vectors.append(annihilator[:, here] @ pull)
    products = np.array(vectors) @ np.array(vectors).T
    return variance, np.trace(products) ** 2 / np.sum(products**2)


@pytest.mark.parametrize("contrast", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1.0, 0.3, -200.0]])
def test_clustered_errors_and_their_freedom_follow_the_definition(contrast):
    matrix, residual, cluster = problem()
    stderr, dof = covariance(matrix, residual, cluster).error(np.array([contrast], float))
    variance, freedom = by_definition(matrix, residual, cluster, np.array(contrast, float))
    assert stderr[0] == pytest.approx(np.sqrt(variance), rel=1e-9)
    assert dof[0] == pytest.approx(freedom, rel=1e-9)


def test_without_clusters_it_is_the_textbook_covariance():
    matrix, residual, _ = problem()
    found = covariance(matrix, residual)
    expected = np.linalg.inv(matrix.T @ matrix) * (residual @ residual) / (len(residual) - 3)
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)
    assert found.error(np.eye(3))[1] == pytest.approx([87.0] * 3)


def test_few_clusters_teach_nothing_about_correlation():
    matrix, residual, cluster = problem()
    assert covariance(matrix, residual, cluster // 2).clusters == 0
    assert covariance(matrix, residual, cluster).clusters == 9


def test_a_direction_without_information_gets_no_variance_and_harms_no_other():
    matrix, residual, cluster = problem()
    doubled = np.column_stack([matrix, matrix[:, 1] * 2.0])
    clean, flat = covariance(matrix, residual, cluster), covariance(doubled, residual, cluster)
    assert flat.basis.shape == (4, 3)
    assert flat.error(np.eye(4))[0][[0, 2]] == pytest.approx(clean.error(np.eye(3))[0][[0, 2]], rel=1e-8)
