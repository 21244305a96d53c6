#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "raytracer/core/scene/scene_fields.hpp"

/// Widgets that several panels use.
namespace terravox::panels::widgets {

/// Adds a tooltip to the last item.
void tip(const std::string& text);

struct Typed {
    std::string text;
    bool entered = false;  ///< whether it was confirmed by Enter; else the field lost the focus
};
/// A text field; its text takes effect on Enter or when it loses the focus.
/// @return the text when it has been changed or entered
[[nodiscard]] std::optional<widgets::Typed> text_input(const char* label, const std::string& now,
                                                       std::size_t max_bytes = 400,
                                                       const char* hint = "");

/// A button that resets a value; grey if there is nothing to reset.
[[nodiscard]] bool reset_button(bool enabled);

/// For tests that drive the window: logs the position of the last item at level trace when it has
/// moved.
void report_place(const std::string& name);
/// ImGui::Button whose position is reported (report_place).
[[nodiscard]] bool button(const char* label, bool enabled = true);

}  // namespace terravox::panels::widgets

namespace terravox::panels {

/// Rows of a panel, one for each field of a scene: its name, its value with its unit, and a reset
/// button. Names, ranges and descriptions are those of the list of fields. Made anew for each
/// frame.
class SceneForm {
public:
    /// @param usual a scene of the same world with the values that a reset restores
    SceneForm(scene::Scene& scene, scene::Scene& usual);

    /// Draws the row of a field.
    /// @param path "section.field"
    /// @return whether the field has changed
    bool row(std::string_view path);
    /// The same with another range for the slider, of the usual values. Numbers beyond it may be
    /// typed in, up to the field's own range.
    /// @param from initial value of an optional field; NaN: 0, or the range's end nearest to it
    bool row(std::string_view path, double low, double high,
             double from = std::numeric_limits<double>::quiet_NaN());
    /// Draws several rows, one below the other.
    bool rows(std::initializer_list<std::string_view> paths);

    /// The displayed name and unit of a field: "fov" and "deg".
    struct Label {
        std::string name;
        std::string unit;
    };
    [[nodiscard]] static Label find_label(std::string_view path);

    /// The field that could not be set, and why; empty: none.
    [[nodiscard]] const std::string& problem() const noexcept { return m_problem; }

private:
    using Value = std::variant<double*, std::optional<double>*, int*, std::optional<int>*, bool*,
                               std::string*, std::optional<std::array<double, 3>>*,
                               std::array<int, 2>*, scene::TileSize*, scene::PointList*,
                               core::CameraProjection*, core::CoordinateSpace*, core::SkyModel*,
                               core::ToneCurve*, core::PictureLayers*, core::TiffSamples*,
                               core::Integrator*, core::TileOrder*, core::VoxelColour*,
                               core::AnalysisKind*, core::AnalysisSurface*, core::WallSide*>;
    struct Field {
        Value value;
        Value usual;
        scene::FieldRule rule;
    };
    /// Range of a slider, and the initial value of an optional field.
    struct Range {
        double low;
        double high;
        double from;
    };
    class Row;
    bool draw(std::string_view path, Field& field, const Range& range);

    scene::Scene& m_scene;
    std::map<std::string_view, Field> m_fields;
    std::string m_problem;
};

}  // namespace terravox::panels
