#pragma once

#include <QPolygonF>
#include <QString>
#include <QWidget>
#include <vector>

#include "mlic_ros/panel/panel_model.h"

namespace mlic {

// A curve over the solves on a logarithmic axis; stages on bands of two shades.
class CurveView : public QWidget {
 public:
  // line: a value at which a line is drawn, and what stands at it; 0: none.
  CurveView(const QString& title, double line, const QString& line_text, QWidget* parent);

  void Show(std::vector<CurvePoint> curve);

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  void PaintBands(const QRectF& area, double width, QPainter* painter) const;
  void PaintAxis(const QRectF& area, const LogAxis& axis, QPainter* painter) const;
  // At this height, and what stands at it, where the curve's places leave room.
  void PaintLine(const QRectF& area, double y, const QPolygonF& places, QPainter* painter) const;

  QString title_, line_text_;
  double line_;
  std::vector<CurvePoint> curve_;
};

}  // namespace mlic
