#include "mlic_core/crossmodal/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/hole_filling.h"
#include "mlic_core/crossmodal/projection_table.h"
#include "mlic_core/crossmodal/splat_canvas.h"

namespace mlic {
namespace {

constexpr float kNearest = 0.3f;  // m: nearer points are the vehicle's own; from: guard
// from: guard, from 0.71 on discs of a square grid leave no gap.
constexpr float kSplatSpacings = 0.9f;     // radius of a splat over the spacing of its points
constexpr float kScatterSpacings = 0.65f;  // the same where there is no plane: twigs, not discs
// from: derivation, from 0.71 px on a disc always covers a pixel's centre.
constexpr float kSplatPixels = 0.8f;    // least radius of a splat, px
constexpr float kLargestSplat = 40.0f;  // px; from: guard, time
constexpr float kDensity = 1.5f;        // points drawn for each pixel, at most; from: guard, time
// from: structural, speed only.
constexpr float kShells = 8.0f;  // of cells in each doubling of distance: near ones hide far ones
// from: structural, speed only.
constexpr float kTile = 64.0f;  // px: cells of one shell are drawn tile by tile, which stay in the cache
// from: guard, normals err by some degrees.
constexpr float kBackFacing = 0.1f;  // cosine beyond which a surface shows its other side
// from: guard, division by it.
constexpr float kGrazing = 0.06f;  // cosine below which a slope is not believed

// A cell that may show, where it comes in the order of drawing, and the share of its points that is enough.
struct VisibleCell {
  int shell, tile;
  std::uint32_t cell;
  float share;

  bool operator<(const VisibleCell& other) const {
    return std::tie(shell, tile, cell) < std::tie(other.shell, other.tile, other.cell);
  }
};

}  // namespace

struct ViewRenderer::Implementation {
  // What is worth knowing of a cell before its points are looked at.
  struct CellSummary {
    float spacing = 0.0f;                              // m, mean
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // mean: shorter than one where normals differ
  };

  // T_camera_map at one row, single precision; points are taken relative to the camera before they are
  // turned.
  struct RowPose {
    Eigen::Matrix3f R_camera_map;
    Eigen::Vector3f center;  // of the camera, map frame

    static RowPose At(const RigidTransform& T_map_camera) {
      return {T_map_camera.rotation.conjugate().toRotationMatrix().cast<float>(),
              T_map_camera.translation.cast<float>()};
    }
  };

  const IntensityMap& map;
  CameraIntrinsics intrinsics;
  RenderOptions options;
  ProjectionTable table;
  std::vector<CellSummary> summaries;

  // The view while it is being drawn.
  struct Drawing {
    std::vector<RowPose> rows;  // one, or one for each row of a rolling shutter
    SplatCanvas canvas;

    const RowPose& PoseAt(float row) const {
      const int last = static_cast<int>(rows.size()) - 1;
      return rows[std::clamp(static_cast<int>(row + 0.5f), 0, last)];
    }
  };

  std::vector<VisibleCell> VisibleCells(const Drawing& drawing) const;
  bool Place(const Drawing& drawing, const SurfacePoint& point, float scale, float* row, Splat* splat) const;
  void DrawCell(const MapCell& cell, float share, Drawing* drawing) const;
  RenderedView Finish(const Drawing& drawing) const;
};

// A cell is left out when it is behind or beside the image or too far; a share of the points of the others is
// enough for their pixels. In the order to draw them.
std::vector<VisibleCell> ViewRenderer::Implementation::VisibleCells(const Drawing& drawing) const {
  std::vector<VisibleCell> visible;
  const float width = static_cast<float>(intrinsics.width), height = static_cast<float>(intrinsics.height);
  const RowPose& pose = drawing.PoseAt(0.5f * height);
  for (std::uint32_t c = 0; c < map.cells.size(); ++c) {
    const MapCell& cell = map.cells[c];
    const Eigen::Vector3f offset = cell.center - pose.center;
    const float distance = offset.norm();
    if (distance - cell.radius > options.farthest) continue;
    const float nearest = std::max(kNearest, distance - cell.radius);
    const int shell = static_cast<int>(kShells * std::log2(nearest / kNearest));
    ProjectionTable::Pixel pixel;
    if (distance < 3.0f * cell.radius) {
      visible.push_back({shell, 0, c, 1.0f});
      continue;
    }
    if (!table.Project(pose.R_camera_map * offset, distance, &pixel)) {
      // Its center is outside of what the camera sees, but its border may be inside.
      if (distance < 10.0f * cell.radius) visible.push_back({shell, 0, c, 1.0f});
      continue;
    }
    const float per_metre = 0.5f * (1.0f + pixel.qx * pixel.qx + pixel.qy * pixel.qy) / distance;
    const float area = std::abs(pixel.u_x * pixel.v_y - pixel.u_y * pixel.v_x) * per_metre * per_metre;
    const float radius = 2.0f * std::sqrt(area) * cell.radius + 2.0f;
    if (pixel.u < -radius || pixel.v < -radius || pixel.u > width + radius || pixel.v > height + radius)
      continue;
    const CellSummary& summary = summaries[c];
    const float facing = std::abs(summary.normal.dot(offset)) / distance + 1.0f - summary.normal.norm();
    const float pixels = area * summary.spacing * summary.spacing * std::min(1.0f, facing);
    const int tile = static_cast<int>(std::max(0.0f, pixel.v) / kTile) * 1024 +
                     static_cast<int>(std::max(0.0f, pixel.u) / kTile);
    visible.push_back({shell, tile, c, std::min(1.0f, kDensity * pixels)});
  }
  std::sort(visible.begin(), visible.end());
  return visible;
}

// The ellipse of a point's disc. With q the stereographic plane, A = d pixel / d q and Q = d q / d p: the
// disc's covariance in pixels is rho^2 (J J^T - J n n^T J^T), J = A Q, and Q Q^T = K^2 I as q is conformal.
// The range's slope keeps to the disc's plane: -A^-T Q n / (K^2 n.d).
bool ViewRenderer::Implementation::Place(const Drawing& drawing, const SurfacePoint& point, float scale,
                                         float* row, Splat* splat) const {
  ProjectionTable::Pixel pixel;
  const RowPose* pose = &drawing.PoseAt(*row);
  Eigen::Vector3f p = pose->R_camera_map * (point.position - pose->center);
  float range = p.norm();
  if (range < kNearest || range > options.farthest || !table.Project(p, range, &pixel)) return false;
  if (drawing.rows.size() > 1) {
    // The row changes the pose, which changes the row: by far less than it itself changed.
    for (int i = 0; i < 2; ++i) {
      pose = &drawing.PoseAt(pixel.v);
      p = pose->R_camera_map * (point.position - pose->center);
      range = p.norm();
      if (!table.Project(p, range, &pixel)) return false;
    }
    *row = pixel.v;
  }
  const Eigen::Vector3f n = pose->R_camera_map * point.normal, d = p / range;
  const float cosine = n.dot(d);
  if (cosine > kBackFacing) return false;
  splat->u = pixel.u, splat->v = pixel.v, splat->r = range;
  const float s = 1.0f / (range + p.z()),
              K = 0.5f * (1.0f + pixel.qx * pixel.qx + pixel.qy * pixel.qy) / range;
  const float along = (cosine + n.z()) * s;
  const float Qn_x = n.x() * s - pixel.qx * along, Qn_y = n.y() * s - pixel.qy * along;
  const float Jn_x = pixel.u_x * Qn_x + pixel.u_y * Qn_y, Jn_y = pixel.v_x * Qn_x + pixel.v_y * Qn_y;
  const float spacings = point.normal.isZero() ? kScatterSpacings : kSplatSpacings;
  const float rho = spacings * scale * point.spacing, rho2 = rho * rho, K2 = K * K;
  float m_xx = rho2 * (K2 * (pixel.u_x * pixel.u_x + pixel.u_y * pixel.u_y) - Jn_x * Jn_x);
  float m_xy = rho2 * (K2 * (pixel.u_x * pixel.v_x + pixel.u_y * pixel.v_y) - Jn_x * Jn_y);
  float m_yy = rho2 * (K2 * (pixel.v_x * pixel.v_x + pixel.v_y * pixel.v_y) - Jn_y * Jn_y);
  const float shrink = std::min(1.0f, kLargestSplat * kLargestSplat / (m_xx + m_yy + 1e-6f));
  m_xx = m_xx * shrink + kSplatPixels * kSplatPixels;
  m_yy = m_yy * shrink + kSplatPixels * kSplatPixels;
  m_xy *= shrink;
  const float inverse = 1.0f / (m_xx * m_yy - m_xy * m_xy);
  splat->xx = m_yy * inverse, splat->xy = -m_xy * inverse, splat->yy = m_xx * inverse;
  splat->half_width = std::sqrt(m_xx), splat->half_height = std::sqrt(m_yy);
  const float slope =
      -1.0f / (K2 * std::min(cosine, -kGrazing) * (pixel.u_x * pixel.v_y - pixel.u_y * pixel.v_x));
  splat->gx = slope * (pixel.v_y * Qn_x - pixel.v_x * Qn_y);
  splat->gy = slope * (pixel.u_x * Qn_y - pixel.u_y * Qn_x);
  return splat->u > -splat->half_width && splat->v > -splat->half_height &&
         splat->u < intrinsics.width - 1 + splat->half_width &&
         splat->v < intrinsics.height - 1 + splat->half_height;
}

void ViewRenderer::Implementation::DrawCell(const MapCell& cell, float share, Drawing* drawing) const {
  const std::uint32_t all = cell.end - cell.begin;
  const std::uint32_t count = std::min(all, static_cast<std::uint32_t>(std::ceil(share * all)));
  const float scale = std::sqrt(static_cast<float>(all) / static_cast<float>(count));
  float row = 0.5f * intrinsics.height;
  for (std::uint32_t k = cell.begin; k < cell.begin + count; ++k) {
    Splat splat;
    if (!Place(*drawing, map.points[k], scale, &row, &splat)) continue;
    splat.brightness = map.points[k].intensity;
    splat.weight = map.points[k].weight;
    splat.point = static_cast<std::int32_t>(k);
    drawing->canvas.Draw(splat);
  }
}

RenderedView ViewRenderer::Implementation::Finish(const Drawing& drawing) const {
  RenderedView view;
  const cv::Size size(intrinsics.width, intrinsics.height);
  view.intensity = cv::Mat(size, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  view.depth = cv::Mat::zeros(size, CV_32F);
  view.normal = cv::Mat::zeros(size, CV_32FC3);
  view.point = cv::Mat(size, CV_32S, cv::Scalar(-1));
  view.spacing = cv::Mat::zeros(size, CV_32F);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const SplatCanvas::Pixel& pixel = drawing.canvas.pixel(column, row);
      if (pixel.best < 0) continue;
      view.intensity.at<float>(row, column) = pixel.brightness / pixel.weight;
      view.depth.at<float>(row, column) = pixel.range / pixel.weight;
      const Eigen::Vector3f& n = map.points[pixel.best].normal;
      view.normal.at<cv::Vec3f>(row, column) = cv::Vec3f(n.x(), n.y(), n.z());
      view.point.at<std::int32_t>(row, column) = pixel.best;
      view.spacing.at<float>(row, column) = map.points[pixel.best].spacing;
    }
  }
  return view;
}

ViewRenderer::ViewRenderer(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                           const RenderOptions& options) {
  std::vector<Implementation::CellSummary> summaries(map.cells.size());
  ParallelFor(map.cells.size(), [&](std::size_t c) {
    const MapCell& cell = map.cells[c];
    const float share = 1.0f / static_cast<float>(cell.end - cell.begin);
    for (std::uint32_t k = cell.begin; k < cell.end; ++k) {
      summaries[c].spacing += share * map.points[k].spacing;
      summaries[c].normal += share * map.points[k].normal;
    }
  });
  implementation_.reset(
      new Implementation{map, intrinsics, options, ProjectionTable(intrinsics), std::move(summaries)});
}

ViewRenderer::~ViewRenderer() = default;

RenderedView ViewRenderer::Render(const ViewPose& pose) const {
  const Implementation& self = *implementation_;
  Implementation::Drawing drawing{{}, SplatCanvas(self.intrinsics.width, self.intrinsics.height)};
  if (pose.rolling) {
    for (int row = 0; row < self.intrinsics.height; ++row)
      drawing.rows.push_back(Implementation::RowPose::At(pose.T_map_camera(row)));
  } else {
    drawing.rows.push_back(Implementation::RowPose::At(pose.T_map_camera(0.0)));
  }
  for (const VisibleCell& v : self.VisibleCells(drawing))
    self.DrawCell(self.map.cells[v.cell], v.share, &drawing);
  RenderedView view = self.Finish(drawing);
  FillHoles(self.map, self.intrinsics.parameters[0], &view);
  return view;
}

std::vector<RenderedView> RenderViews(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                      const std::vector<ViewPose>& poses, const RenderOptions& options) {
  const ViewRenderer renderer(map, intrinsics, options);
  std::vector<RenderedView> views(poses.size());
  ParallelFor(poses.size(), [&](std::size_t i) { views[i] = renderer.Render(poses[i]); });
  return views;
}

}  // namespace mlic
