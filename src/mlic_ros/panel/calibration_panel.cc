#include "mlic_ros/panel/calibration_panel.h"

#include <rviz/display.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/visualization_manager.h>
#include <rviz/window_manager_interface.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QComboBox>
#include <QEvent>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QKeySequence>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <array>
#include <pluginlib/class_list_macros.hpp>

#include "mlic/Choose.h"
#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

constexpr const char *kPause = "Pa&use", *kContinue = "Contin&ue";

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
  table->verticalHeader()->setDefaultSectionSize(table->fontMetrics().height() + 6);  // ten sensors in view
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
  sigmas_ = new CurveView("largest sigma of a sensor's position, mm", 0.0, "", this);
  residuals_ = new CurveView("mean squared residual over its variance", 1.0, "as their noise", this);
  sensors_ = MakeTable(this);
  legend_ = new QLabel(this);
  legend_->setTextFormat(Qt::RichText);
  legend_->setStyleSheet("color: #d0d4dc; background-color: #14141a; padding: 2px;");  // as the scene
  answer_ = new QLabel(this);
  for (QLabel* text : {legend_, answer_}) text->setWordWrap(true);
  auto* all = new QVBoxLayout(this);
  for (QWidget* widget : {static_cast<QWidget*>(verdict_), static_cast<QWidget*>(messages_),
                          static_cast<QWidget*>(stage_), static_cast<QWidget*>(progress_)}) {
    all->addWidget(widget);
  }
  for (CurveView* curve : {changes_, sigmas_, residuals_}) all->addWidget(curve, 2);
  all->addWidget(sensors_, 5);
  all->addLayout(MakeSceneButtons());
  all->addWidget(legend_);
  all->addLayout(MakeRunButtons());
  all->addWidget(answer_);
  connect(sensors_, &QTableWidget::cellClicked, this, [this](int row, int) { LookAt(row); });
  connect(sensors_, &QTableWidget::cellActivated, this, [this](int row, int) { LookAt(row); });
  connect(sensors_, &QTableWidget::itemChanged, this,
          [this](const QTableWidgetItem* item) { OnItemChanged(*item); });
  ShowVerdict();
}

QPushButton* CalibrationPanel::MakeButton(const QString& text, const QString& tip) {
  auto* button = new QPushButton(text, this);
  button->setToolTip(tip);
  button->setEnabled(false);
  // Else two rows of buttons would make the panel as wide as the scene.
  button->setMinimumWidth(button->fontMetrics().boundingRect(text).width() + 12);
  return button;
}

QHBoxLayout* CalibrationPanel::MakeSceneButtons() {
  previous_ = MakeButton("<", "The round before the shown one; Alt+Left (service /mlic/round)");
  next_ = MakeButton(">", "The round after the shown one; Alt+Right (service /mlic/round)");
  previous_->setShortcut(QKeySequence("Alt+Left"));
  next_->setShortcut(QKeySequence("Alt+Right"));
  latest_ = MakeButton("&Latest", "The latest state again (service /mlic/round)");
  round_ = new QLabel(this);
  blink_ =
      MakeButton("&Blink", "Shows guesses and first map by turns with what is shown (service /mlic/blink)");
  blink_->setCheckable(true);
  colour_by_ = new QComboBox(this);
  auto* colour_by_text = new QLabel("colour b&y", this);
  colour_by_text->setBuddy(colour_by_);
  colour_by_->setToolTip("What the points' colours say (service /mlic/colour_by)");
  for (const char* word : {"sensor", "residual", "plane"}) colour_by_->addItem(word);
  connect(previous_, &QPushButton::clicked, this, [this] { Choose("/mlic/round", "previous"); });
  connect(next_, &QPushButton::clicked, this, [this] { Choose("/mlic/round", "next"); });
  connect(latest_, &QPushButton::clicked, this, [this] { Choose("/mlic/round", "latest"); });
  connect(blink_, &QPushButton::clicked, this, [this](bool on) { Switch("/mlic/blink", on); });
  connect(colour_by_, QOverload<int>::of(&QComboBox::activated), this,
          [this](int) { Choose("/mlic/colour_by", colour_by_->currentText().toStdString()); });
  auto* row = new QHBoxLayout;
  for (QWidget* widget :
       {static_cast<QWidget*>(previous_), static_cast<QWidget*>(round_), static_cast<QWidget*>(next_),
        static_cast<QWidget*>(latest_), static_cast<QWidget*>(blink_), static_cast<QWidget*>(colour_by_text),
        static_cast<QWidget*>(colour_by_)}) {
    row->addWidget(widget);
  }
  return row;
}

QHBoxLayout* CalibrationPanel::MakeRunButtons() {
  whole_map_ = MakeButton("&Whole map", "Looks at the whole map, and follows it");
  pause_ = MakeButton(kPause, "The calibration stands still until it is pressed again (service /mlic/pause)");
  pause_->setCheckable(true);
  export_ =
      MakeButton("&Export now",
                 "Writes the state of the last round into the folder unfinished of the output directory, "
                 "marked as not finished (service /mlic/export)");
  cancel_ = MakeButton(
      "&Cancel", "Ends the calibration as Ctrl-C does; finished stages are kept (service /mlic/cancel)");
  connect(whole_map_, &QPushButton::clicked, this, [this] { LookAtMap(); });
  connect(pause_, &QPushButton::clicked, this, [this](bool on) { Switch("/mlic/pause", on); });
  connect(export_, &QPushButton::clicked, this, [this] { Trigger("/mlic/export"); });
  connect(cancel_, &QPushButton::clicked, this, [this] { Trigger("/mlic/cancel"); });
  auto* row = new QHBoxLayout;
  for (QPushButton* button : {whole_map_, pause_, export_, cancel_}) row->addWidget(button);
  return row;
}

void CalibrationPanel::onInitialize() {
  view_ = std::make_unique<MapView>(vis_manager_);
  // RViz calls back in its own thread, in which widgets may be changed.
  status_subscriber_ = node_.subscribe<Status>("/mlic/status", 1,
                                               [this](const Status::ConstPtr& status) { OnStatus(*status); });
  if (!ros::param::param("~asks_to_save", true))
    vis_manager_->getWindowManager()->getParentWindow()->installEventFilter(this);
  AwaitImages("/mlic/tracks");
  AwaitImages("/mlic/projections");
}

bool CalibrationPanel::eventFilter(QObject* window, QEvent* event) {
  if (event->type() == QEvent::Close) static_cast<QWidget*>(window)->setWindowModified(false);
  return rviz::Panel::eventFilter(window, event);
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
  fills_ = true;
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
      if (column == 0) {
        item->setCheckState(sensor.shown ? Qt::Checked : Qt::Unchecked);
        item->setToolTip("Shown in the scene (services /mlic/show and /mlic/hide)");
      }
      if (column > 1) item->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
      if (column == 1) item->setForeground(ColourOfSensor(sensor.state));
    }
  }
  fills_ = false;
}

void CalibrationPanel::ShowScene() {
  colour_by_->setCurrentText(ToText(status_.colour_by));
  legend_->setText(ToText(LegendHtml(status_)));
  legend_->setVisible(!status_.legend.empty());
  round_->setText(ToText(RoundText(status_)));
  const bool running = status_.state == Status::RUNNING;
  for (QPushButton* button : {previous_, blink_}) button->setEnabled(status_.rounds > 0);
  for (QPushButton* button : {next_, latest_}) button->setEnabled(status_.shown_round > 0);
  blink_->setChecked(status_.blinks);
  pause_->setChecked(status_.paused);
  pause_->setText(status_.paused ? kContinue : kPause);
  for (QPushButton* button : {pause_, cancel_}) button->setEnabled(running);
  export_->setEnabled(running && status_.rounds > 0);
  // The configuration looks at the frames that calibrate_node has by itself.
  const QString map = ToText(status_.frame_prefix + "map");
  if (vis_manager_->getFixedFrame() == "mlic/map" && map != "mlic/map") vis_manager_->setFixedFrame(map);
}

void CalibrationPanel::OnStatus(const Status& status) {
  if (status.state != status_.state) answer_->clear();  // it was of what has ended
  status_ = status;
  toggled_ = false;  // of a box that was not changed by a click
  const bool running = status.state == Status::RUNNING;
  verdict_->setText(ToText(VerdictWord(status)));
  ShowVerdict();
  const std::string lines = MessageLines(status);
  messages_->setText(ToText(lines).trimmed());
  messages_->setVisible(!lines.empty());
  stage_->setText(running ? ToText(StageLine(status)) : "");
  stage_->setVisible(running);
  progress_->setValue(static_cast<int>(1000.0f * status.run_progress));
  progress_->setFormat(ToText(ProgressLine(status)));
  changes_->Show(ChangeCurve(status));
  sigmas_->Show(SigmaCurve(status));
  residuals_->Show(ResidualCurve(status));
  ShowSensors();
  ShowScene();
  const std::optional<Viewpoint> map = ViewOfMap(status);
  whole_map_->setEnabled(map.has_value());
  if (map) view_->FollowMap(*map);
}

void CalibrationPanel::LookAt(int row) {
  const SensorRow& sensor = rows_.at(static_cast<std::size_t>(row));
  const bool is_box = toggled_;
  toggled_ = false;
  if (IsFound(sensor.state) && !is_box)
    view_->LookAtFrame(status_.frame_prefix + sensor.frame, ViewOfSensor(status_));
}

void CalibrationPanel::LookAtMap() {
  const std::optional<Viewpoint> map = ViewOfMap(status_);
  if (map) view_->LookAtMap(*map);
}

void CalibrationPanel::OnItemChanged(const QTableWidgetItem& item) {
  if (fills_ || item.column() != 0) return;
  const std::string& name = rows_.at(static_cast<std::size_t>(item.row())).name;
  toggled_ = true;
  Choose(item.checkState() == Qt::Checked ? "/mlic/show" : "/mlic/hide", name);
}

void CalibrationPanel::Tell(bool reached, const std::string& service, const std::string& message) {
  answer_->setText(ToText(reached ? message : service + " does not answer"));
}

void CalibrationPanel::Trigger(const std::string& service) {
  std_srvs::Trigger call;
  const bool reached = ros::service::call(service, call);
  Tell(reached, service, call.response.message);
}

void CalibrationPanel::Switch(const std::string& service, bool on) {
  std_srvs::SetBool call;
  call.request.data = static_cast<std::uint8_t>(on);
  const bool reached = ros::service::call(service, call);
  Tell(reached, service, call.response.message);
}

void CalibrationPanel::Choose(const std::string& service, const std::string& word) {
  mlic::Choose call;
  call.request.value = word;
  const bool reached = ros::service::call(service, call);
  Tell(reached, service, call.response.message);
}

}  // namespace mlic

PLUGINLIB_EXPORT_CLASS(mlic::CalibrationPanel, rviz::Panel)
