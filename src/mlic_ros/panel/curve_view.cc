#include "mlic_ros/panel/curve_view.h"

#include <QPainter>
#include <QPolygonF>
#include <utility>

namespace mlic {
namespace {

// Constants of this file, from: structural, how the panel looks.

const QColor kGround(28, 30, 38), kBand(38, 42, 54), kGrid(70, 75, 90), kText(205, 210, 220),
    kCurve(90, 190, 255), kLine(120, 220, 130);
constexpr int kLeft = 44, kTop = 30, kMargin = 8;  // px
constexpr double kLineText = 16.0;                 // px, height

}  // namespace

CurveView::CurveView(const QString& title, double line, const QString& line_text, QWidget* parent)
    : QWidget(parent), title_(title), line_text_(line_text), line_(line) {
  setMinimumHeight(84);
}

void CurveView::Show(std::vector<CurvePoint> curve) {
  curve_ = std::move(curve);
  update();
}

void CurveView::PaintBands(const QRectF& area, double width, QPainter* painter) const {
  bool shaded = false;
  for (std::size_t k = 0; k < curve_.size(); ++k) {
    if (k > 0 && curve_[k].stage != curve_[k - 1].stage) shaded = !shaded;
    if (!shaded) continue;
    const double x = area.left() + width * curve_[k].solve;
    painter->fillRect(QRectF(x, area.top(), width, area.height()), kBand);
  }
}

void CurveView::PaintAxis(const QRectF& area, const LogAxis& axis, QPainter* painter) const {
  const int step = 1 + (axis.highest - axis.lowest) / 4;  // few enough to be read
  for (int power = axis.lowest; power <= axis.highest; power += step) {
    const double y = area.bottom() -
                     area.height() * (power - axis.lowest) / static_cast<double>(axis.highest - axis.lowest);
    painter->setPen(kGrid);
    painter->drawLine(QPointF(area.left(), y), QPointF(area.right(), y));
    painter->setPen(kText);
    const QString label =
        power >= -2 && power <= 3 ? QString::number(std::pow(10.0, power)) : QString("1e%1").arg(power);
    painter->drawText(QRectF(0.0, y - 8.0, kLeft - 4.0, 16.0), Qt::AlignRight | Qt::AlignVCenter, label);
  }
}

void CurveView::PaintLine(const QRectF& area, double y, const QPolygonF& places, QPainter* painter) const {
  painter->setPen(QPen(kLine, 1.5, Qt::DashLine));
  painter->drawLine(QPointF(area.left(), y), QPointF(area.right(), y));
  // Its text at one of its ends, above or below it; neither the title's place nor that below the ground is
  // its.
  const double text_width = painter->fontMetrics().boundingRect(line_text_).width() + 2.0;
  std::vector<Box> boxes;
  for (const double left : {area.left(), area.right() - text_width}) {
    for (const double top : {y - 1.0 - kLineText, y + 1.0}) {
      if (top >= area.top() && top + kLineText <= height())
        boxes.push_back({left, top, text_width, kLineText});
    }
  }
  if (boxes.empty()) return;
  std::vector<Place> curve;
  for (const QPointF& place : places) curve.push_back({place.x(), place.y()});
  const Box& box = boxes[FreestBox(boxes, curve)];
  painter->drawText(QRectF(box.left, box.top, box.width, box.height), Qt::AlignLeft, line_text_);
}

void CurveView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.fillRect(rect(), kGround);
  painter.setPen(kText);
  QString title = title_;
  if (!curve_.empty()) title += ": " + QString::fromStdString(ShortNumberText(curve_.back().value));
  painter.drawText(QRectF(kMargin, 3.0, width() - 2.0 * kMargin, 18.0), Qt::AlignLeft, title);
  const QRectF area(kLeft, kTop, width() - kLeft - kMargin, height() - kTop - kMargin);
  if (curve_.empty()) {
    painter.setPen(kGrid);
    painter.drawText(area, Qt::AlignCenter, "not measured yet");
    return;
  }
  const LogAxis axis = FitLogAxis(curve_, line_ > 0.0 ? line_ : curve_.front().value);
  const double step = area.width() / (curve_.back().solve + 1.0);
  PaintBands(area, step, &painter);
  PaintAxis(area, axis, &painter);
  const auto height_of = [&](double value) { return area.bottom() - area.height() * axis.Place(value); };
  QPolygonF places;
  for (const CurvePoint& point : curve_) {
    places << QPointF(area.left() + step * (point.solve + 0.5), height_of(point.value));
  }
  if (line_ > 0.0) PaintLine(area, height_of(line_), places, &painter);
  painter.setPen(QPen(kCurve, 2.0));
  painter.drawPolyline(places);
  painter.setBrush(kCurve);
  for (const QPointF& place : places) painter.drawEllipse(place, 2.5, 2.5);
}

}  // namespace mlic
