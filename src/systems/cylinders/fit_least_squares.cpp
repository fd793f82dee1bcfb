#include "cylinders/fit_least_squares.h"

#include <cmath>
#include <stdexcept>
#include <unsupported/Eigen/NonLinearOptimization>

namespace rangegrasp::cylinders {
namespace {

/// What Eigen's Levenberg-Marquardt asks for.
class Residuals {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  explicit Residuals(geometry::PointSpan points) : points_(points) {}

  int inputs() const { return BarrelParameters::RowsAtCompileTime; }
  int values() const { return static_cast<int>(points_.size()); }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& values) const {
    const BarrelParameters parameters = x;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      values[static_cast<Eigen::Index>(i)] = BarrelResidual(parameters, points_[i]);
    }
    return 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) const {
    const BarrelParameters parameters = x;
    BarrelParameters gradient;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      BarrelResidual(parameters, points_[i], &gradient);
      jacobian.row(static_cast<Eigen::Index>(i)) = gradient.transpose();
    }
    return 0;
  }

 private:
  geometry::PointSpan points_;
};

std::optional<Barrel> BarrelOf(const Eigen::VectorXd& x, const Eigen::Vector3d& mean) {
  const Eigen::Vector3d d = x.segment<3>(3);
  if (!x.allFinite() || d.norm() == 0.0 || x[6] <= 0.0) return std::nullopt;
  Barrel barrel;
  barrel.axis.direction = d.normalized();
  const Eigen::Vector3d c = x.head<3>();
  barrel.axis.point = c + (mean - c).dot(barrel.axis.direction) * barrel.axis.direction;
  barrel.radius_m = x[6];
  return barrel;
}

}  // namespace

double BarrelResidual(const BarrelParameters& x, const Eigen::Vector3d& p,
                      BarrelParameters* gradient) {
  const Eigen::Vector3d d = x.segment<3>(3);
  const Eigen::Vector3d offset = p - x.head<3>();
  const double along = offset.dot(d) / d.squaredNorm();
  const Eigen::Vector3d across = offset - along * d;
  const double distance = across.norm();
  if (gradient != nullptr) {
    // On the axis itself the direction is free; none is as good as another.
    const Eigen::Vector3d outward =
        distance > 0.0 ? Eigen::Vector3d(across / distance) : Eigen::Vector3d::Zero();
    gradient->head<3>() = -outward;
    gradient->segment<3>(3) = -along * outward;
    (*gradient)[6] = -1.0;
  }
  return distance - x[6];
}

std::optional<Barrel> StartByComponents(geometry::PointSpan points) {
  const auto line = FitLine(points);
  if (!line) return std::nullopt;
  double sum_m = 0.0;
  for (const auto& p : points) sum_m += line->Distance(p);
  return Barrel{*line, sum_m / static_cast<double>(points.size())};
}

std::optional<BarrelFit> FitLeastSquares(geometry::PointSpan points,
                                         const LeastSquaresOptions& options) {
  if (options.iterations < 1) {
    throw std::invalid_argument("FitLeastSquares: iterations must be >= 1");
  }
  if (points.size() < static_cast<std::size_t>(BarrelParameters::RowsAtCompileTime)) {
    return std::nullopt;
  }
  const auto start = StartByComponents(points);
  if (!start) return std::nullopt;
  Eigen::VectorXd x(BarrelParameters::RowsAtCompileTime);
  x << start->axis.point, start->axis.direction, start->radius_m;

  Residuals residuals(points);
  Eigen::LevenbergMarquardt<Residuals> solver(residuals);
  auto status = solver.minimizeInit(x);
  BarrelFit fit;
  while (status == Eigen::LevenbergMarquardtSpace::NotStarted ||
         status == Eigen::LevenbergMarquardtSpace::Running) {
    if (fit.iterations == options.iterations) break;
    status = solver.minimizeOneStep(x);
    ++fit.iterations;
  }
  const auto barrel = BarrelOf(x, start->axis.point);
  if (!barrel) return std::nullopt;
  fit.barrel = *barrel;
  return fit;
}

}  // namespace rangegrasp::cylinders
