#include "mlic_ros/panel/calibration_panel.h"

#include <rviz/display.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/visualization_manager.h>
#include <std_srvs/Trigger.h>

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <array>
#include <pluginlib/class_list_macros.hpp>

#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

QString ToText(const std::string& text) { return QString::fromStdString(text); }

QColor ColourOf(const Status& status) {
  const std::array<float, 3> colour = VerdictColour(status);
  return QColor::fromRgbF(colour[0], colour[1], colour[2]);
}

QColor ColourOfSensor(std::uint8_t state) {
  switch (state) {
    case SensorStatus::TRUSTED:
      return QColor(30, 140, 60);
    case SensorStatus::HELD:
      return QColor(160, 110, 0);
    case SensorStatus::REJECTED:
      return QColor(190, 40, 30);
    default:
      return QColor(90, 95, 105);
  }
}

QTableWidget* MakeTable(QWidget* parent) {
  auto* table = new QTableWidget(0, SensorRow::kColumns, parent);
  QStringList titles;
  for (const char* title : SensorRow::Titles()) titles << title;
  table->setHorizontalHeaderLabels(titles);
  table->verticalHeader()->hide();
  table->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table->horizontalHeader()->setStretchLastSection(true);
  table->horizontalHeader()->setHighlightSections(false);
  table->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table->setSelectionBehavior(QAbstractItemView::SelectRows);
  table->setSelectionMode(QAbstractItemView::SingleSelection);
  return table;
}

}  // namespace

CalibrationPanel::CalibrationPanel(QWidget* parent) : rviz::Panel(parent) {
  verdict_ = new QLabel("WAITING", this);
  verdict_->setAlignment(Qt::AlignCenter);
  messages_ = new QLabel("for a calibration: no message on /mlic/status yet", this);
  stage_ = new QLabel(this);
  for (QLabel* text : {messages_, stage_}) text->setWordWrap(true);
  progress_ = new QProgressBar(this);
  progress_->setRange(0, 1000);
  changes_ = new CurveView("largest change of a sensor in a round, in its sigmas", 1.0, "one sigma", this);
  costs_ = new CurveView("cost", 0.0, "", this);
  sensors_ = MakeTable(this);
  cancel_ = new QPushButton("Cancel", this);
  cancel_->setToolTip("Ends the calibration as Ctrl-C does; finished stages are kept (service /mlic/cancel)");
  cancel_->setEnabled(false);
  whole_map_ = new QPushButton("Whole map", this);
  whole_map_->setToolTip("Looks at the whole map, and follows it");
  whole_map_->setEnabled(false);
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(whole_map_);
  buttons->addWidget(cancel_);
  auto* all = new QVBoxLayout(this);
  for (QWidget* widget : {static_cast<QWidget*>(verdict_), static_cast<QWidget*>(messages_),
                          static_cast<QWidget*>(stage_), static_cast<QWidget*>(progress_)}) {
    all->addWidget(widget);
  }
  all->addWidget(changes_, 4);
  all->addWidget(costs_, 3);
  all->addWidget(sensors_, 3);
  all->addLayout(buttons);
  connect(cancel_, &QPushButton::clicked, this, [this] { Cancel(); });
  connect(whole_map_, &QPushButton::clicked, this, [this] { LookAtMap(); });
  connect(sensors_, &QTableWidget::cellClicked, this, [this](int row, int) { LookAt(row); });
  ShowVerdict();
}

void CalibrationPanel::onInitialize() {
  view_ = std::make_unique<MapView>(vis_manager_);
  // RViz calls back in its own thread, in which widgets may be changed.
  status_subscriber_ = node_.subscribe<Status>("/mlic/status", 1,
                                               [this](const Status::ConstPtr& status) { OnStatus(*status); });
  AwaitImages("/mlic/tracks");
  AwaitImages("/mlic/projections");
}

void CalibrationPanel::AwaitImages(const std::string& topic) {
  images_[topic] =
      node_.subscribe<sensor_msgs::Image>(topic, 1, [this, topic](const sensor_msgs::Image::ConstPtr&) {
        rviz::DisplayGroup* root = vis_manager_->getRootDisplayGroup();
        for (int k = 0; k < root->numDisplays(); ++k) {
          rviz::Display* display = root->getDisplayAt(k);
          if (display->subProp("Image Topic")->getValue().toString() == ToText(topic))
            display->setEnabled(true);
        }
        images_.at(topic).shutdown();
      });
}

void CalibrationPanel::ShowVerdict() {
  verdict_->setStyleSheet(QString("font-size: 30px; font-weight: bold; padding: 6px; color: #14161c; "
                                  "background-color: %1;")
                              .arg(ColourOf(status_).name()));
}

void CalibrationPanel::ShowSensors() {
  rows_ = SensorRows(status_);
  sensors_->setRowCount(static_cast<int>(rows_.size()));
  for (int row = 0; row < sensors_->rowCount(); ++row) {
    const SensorRow& sensor = rows_[static_cast<std::size_t>(row)];
    for (int column = 0; column < SensorRow::kColumns; ++column) {
      auto* item = sensors_->item(row, column);
      if (item == nullptr) {
        item = new QTableWidgetItem;
        sensors_->setItem(row, column, item);
      }
      item->setText(ToText(sensor.cells[static_cast<std::size_t>(column)]));
      item->setToolTip(ToText(sensor.note));
      if (column > 1) item->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      if (column == 1) item->setForeground(ColourOfSensor(sensor.state));
    }
  }
}

void CalibrationPanel::OnStatus(const Status& status) {
  status_ = status;
  const bool running = status.state == Status::RUNNING;
  verdict_->setText(ToText(VerdictWord(status)));
  ShowVerdict();
  std::string lines;
  for (std::size_t k = 0; k < status.messages.size() && k < 3; ++k) lines += status.messages[k] + "\n";
  messages_->setText(ToText(lines).trimmed());
  messages_->setVisible(!lines.empty());
  stage_->setText(running ? ToText(StageLine(status)) : "");
  stage_->setVisible(running);
  progress_->setValue(static_cast<int>(1000.0f * status.run_progress));
  progress_->setFormat(ToText(ProgressLine(status)));
  changes_->Show(ChangeCurve(status));
  costs_->Show(CostCurve(status));
  ShowSensors();
  cancel_->setEnabled(running);
  const std::optional<Viewpoint> map = ViewOfMap(status);
  whole_map_->setEnabled(map.has_value());
  if (map) view_->FollowMap(*map);
}

void CalibrationPanel::LookAt(int row) {
  const SensorRow& sensor = rows_.at(static_cast<std::size_t>(row));
  if (IsFound(sensor.state)) view_->LookAtFrame(sensor.frame, ViewOfSensor(status_));
}

void CalibrationPanel::LookAtMap() {
  const std::optional<Viewpoint> map = ViewOfMap(status_);
  if (map) view_->LookAtMap(*map);
}

void CalibrationPanel::Cancel() {
  std_srvs::Trigger trigger;
  cancel_->setEnabled(false);
  const bool reached = ros::service::call("/mlic/cancel", trigger);
  messages_->setText(reached ? ToText(trigger.response.message) : QString("/mlic/cancel does not answer"));
  messages_->setVisible(true);
}

}  // namespace mlic

PLUGINLIB_EXPORT_CLASS(mlic::CalibrationPanel, rviz::Panel)
