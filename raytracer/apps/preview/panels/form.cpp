#include "raytracer/apps/preview/panels/form.hpp"

#include <imgui.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::panels::widgets {

void tip(const std::string& text) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
        return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

std::optional<widgets::Typed> text_input(const char* label, const std::string& now,
                                         std::size_t max_bytes, const char* hint) {
    struct Typing {
        std::vector<char> text;
        int frame = 0;  ///< the last frame that drew it
    };
    // For one frame there are two states: of the field that loses the focus, and of the one that
    // gets it.
    static std::map<ImGuiID, Typing> typing;
    const int frame = ImGui::GetFrameCount();
    std::erase_if(typing, [frame](const auto& t) {
        return t.second.frame < frame - 1;
    });  // fields that are not drawn any more
    const ImGuiID id = ImGui::GetID(label);
    const auto known = typing.find(id);
    std::vector<char> text(max_bytes + 1);
    if (known != typing.end())
        text = known->second.text;
    else
        now.copy(text.data(), max_bytes);
    const bool entered = ImGui::InputTextWithHint(label, hint, text.data(), text.size(),
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    if (ImGui::IsItemActive())
        typing[id] = {text, frame};
    const bool left = ImGui::IsItemDeactivated() && known != typing.end();
    if (!entered && !left)
        return std::nullopt;
    typing.erase(id);
    // Escape reverts the input: ImGui has restored the old text.
    const std::string typed = text.data();
    if (typed == now && !entered)
        return std::nullopt;
    return widgets::Typed{typed, entered};
}

bool reset_button(bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button("x", {ImGui::GetFrameHeight(), 0});
    widgets::tip("reset");
    ImGui::EndDisabled();
    return pressed;
}

void report_place(const std::string& name) {
    if (!util::is_logged(util::LogLevel::kTrace))
        return;
    static std::map<std::string, std::array<float, 4>> reported;
    const ImVec2 low = ImGui::GetItemRectMin();
    const ImVec2 high = ImGui::GetItemRectMax();
    const std::array<float, 4> place{low.x, low.y, high.x, high.y};
    if (reported[name] == place)
        return;
    reported[name] = place;
    util::log_trace("place of {}: {:.0f} {:.0f} {:.0f} {:.0f}", name, low.x, low.y, high.x, high.y);
}

bool button(const char* label, bool enabled) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    widgets::report_place(label);
    return pressed;
}

}  // namespace terravox::panels::widgets

namespace terravox::panels {
namespace {

struct Unit {
    std::string_view ending;
    const char* unit;
};
constexpr const char* kDegrees = "\u00b0";
constexpr std::array kUnits{Unit{"_deg", kDegrees}, Unit{"_m", "m"},      Unit{"_h", "h"},
                            Unit{"_km", "km"},      Unit{"_ev", "stops"}, Unit{"_s", "s"},
                            Unit{"_mib", "MiB"},    Unit{"_px", "px"}};

/// Rounds a slider's number to the displayed digits, as sliders have single precision.
double meant(float v) {
    return std::strtod(fmt::format("{:.6g}", static_cast<double>(v)).c_str(), nullptr);
}

/// The text of a text field.
constexpr std::size_t kMaxText = 200;

std::string find_format_by(double low, double high, const std::string& unit) {
    const double span = high - low;
    const char* digits = span > 400 ? "%.0f" : span > 30 ? "%.1f" : "%.2f";
    return digits + (unit.empty() || unit == kDegrees ? unit : " " + unit);
}

bool is_wide(double low, double high) {
    return low >= 0 && high > 400 * std::max(low, 1.0);
}

bool number(double& value, const scene::FieldRule& rule, double low, double high,
            const std::string& unit) {
    auto v = static_cast<float>(value);
    const bool has_range = std::isfinite(low) && std::isfinite(high);
    ImGuiSliderFlags flags = ImGuiSliderFlags_None;
    if (has_range && is_wide(low, high))
        flags |= ImGuiSliderFlags_Logarithmic;
    const std::string format = find_format_by(low, has_range ? high : low + 100, unit);
    const bool changed = has_range
                             ? ImGui::SliderFloat("##v", &v, static_cast<float>(low),
                                                  static_cast<float>(high), format.c_str(), flags)
                             : ImGui::DragFloat("##v", &v, 0.1f, 0, 0, format.c_str());
    if (!changed)
        return false;
    value = std::clamp(meant(v), rule.min, rule.max);
    return true;
}

bool whole_number(int& value, const scene::FieldRule& rule, double low, double high) {
    const ImGuiSliderFlags flags =
        is_wide(low, high) ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None;
    if (!ImGui::SliderInt("##v", &value, static_cast<int>(low), static_cast<int>(high), "%d",
                          flags))
        return false;
    value = static_cast<int>(std::clamp(static_cast<double>(value), rule.min, rule.max));
    return true;
}

}  // namespace

SceneForm::SceneForm(scene::Scene& scene, scene::Scene& usual) : m_scene(scene) {
    scene::visit_fields(scene,
                        [this](std::string_view path, auto& field, const scene::FieldRule& rule) {
                            m_fields.emplace(path, Field{&field, &field, rule});
                        });
    scene::visit_fields(usual, [this](std::string_view path, auto& field, const scene::FieldRule&) {
        m_fields.at(path).usual = &field;
    });
}

SceneForm::Label SceneForm::find_label(std::string_view path) {
    std::string name(path.substr(path.find('.') + 1)), unit;
    for (const Unit& u : kUnits)
        if (name.size() > u.ending.size() && name.ends_with(u.ending)) {
            name.resize(name.size() - u.ending.size());
            unit = u.unit;
            break;
        }
    std::replace(name.begin(), name.end(), '_', ' ');
    return {name, unit};
}

bool SceneForm::row(std::string_view path) {
    const auto found = m_fields.find(path);
    if (found == m_fields.end())
        throw util::Error("show the field " + std::string(path) + ": no such field of a scene");
    const scene::FieldRule& rule = found->second.rule;
    return draw(path, found->second,
                {rule.min, rule.max, std::numeric_limits<double>::quiet_NaN()});
}

bool SceneForm::row(std::string_view path, double low, double high, double from) {
    const auto found = m_fields.find(path);
    if (found == m_fields.end())
        throw util::Error("show the field " + std::string(path) + ": no such field of a scene");
    return draw(path, found->second, {low, high, from});
}

bool SceneForm::rows(std::initializer_list<std::string_view> paths) {
    bool changed = false;
    for (const auto path : paths)
        changed |= row(path);
    return changed;
}

/// One row, while it is drawn: the widget that suits the type of the field.
class SceneForm::Row {
public:
    Row(SceneForm& form, std::string_view path, Field& field, const Range& range)
        : m_form(form), m_path(path), m_field(field), m_range(range), m_label(find_label(path)) {}

    /// @return the field has changed
    bool draw();

    void operator()(double* v) {
        m_changed |= number(*v, rule(), m_range.low, m_range.high, m_label.unit);
    }
    void operator()(std::optional<double>* v);
    void operator()(int* v) { m_changed |= whole_number(*v, rule(), m_range.low, m_range.high); }
    void operator()(std::optional<int>* v);
    void operator()(bool* v) { m_changed |= ImGui::Checkbox("##v", v); }
    void operator()(std::string* v);
    void operator()(std::optional<std::array<double, 3>>* v);
    void operator()(std::array<int, 2>* v) {
        draw_text(std::to_string((*v)[0]) + "x" + std::to_string((*v)[1]));
    }
    void operator()(scene::TileSize* v) { draw_text(v->text()); }
    void operator()(scene::PointList* v) { draw_text(v->text()); }
    template <core::WordEnum Word>
    void operator()(Word* v) {
        if (const auto word = draw_words(core::to_word(*v)))
            *v = core::from_word<Word>(*word).value_or(*v);
    }

private:
    [[nodiscard]] const scene::FieldRule& rule() const noexcept { return m_field.rule; }
    void draw_text(const std::string& now);
    std::optional<std::string_view> draw_words(std::string_view now);
    template <class Held>
    bool draw_own(std::optional<Held>& value, const Held& first);
    void draw_reset();

    SceneForm& m_form;
    const std::string_view m_path;
    Field& m_field;
    const Range m_range;
    const Label m_label;
    bool m_changed = false;
};

void SceneForm::Row::draw_text(const std::string& now) {
    const auto typed = widgets::text_input("##v", now, kMaxText);
    if (!typed || typed->text == now)
        return;
    try {
        scene::set_field(m_form.m_scene, std::string(m_path), typed->text);
        m_changed = true;
    } catch (const util::Error& e) {
        m_form.m_problem = e.what();
    }
}

/// A combo box of the words of a field.
/// @return the chosen one, if any
std::optional<std::string_view> SceneForm::Row::draw_words(std::string_view now) {
    std::optional<std::string_view> chosen;
    const auto shown = [](std::string_view word) {
        return word.empty() ? std::string("as the data say") : std::string(word);
    };
    if (!ImGui::BeginCombo("##v", shown(now).c_str()))
        return chosen;
    for (const std::string_view word : rule().words)
        if (ImGui::Selectable(shown(word).c_str(), word == now))
            chosen = word;
    ImGui::EndCombo();
    m_changed |= chosen.has_value();
    return chosen;
}

/// A check box that gives an optional field a value, or none.
/// @param first initial value
/// @return whether the field has a value
template <class Held>
bool SceneForm::Row::draw_own(std::optional<Held>& value, const Held& first) {
    bool own = value.has_value();
    if (ImGui::Checkbox("##own", &own)) {
        if (own)
            value = first;
        else
            value.reset();
        m_changed = true;
    }
    widgets::tip(own ? "untick: as usual" : "tick: a value of its own");
    ImGui::SameLine();
    const float left_px = ImGui::GetContentRegionAvail().x - ImGui::GetFrameHeight() -
                          ImGui::GetStyle().ItemSpacing.x;
    ImGui::SetNextItemWidth(std::max(left_px, 20.0f));
    if (!value.has_value())
        ImGui::TextDisabled("auto");
    return value.has_value();
}

void SceneForm::Row::operator()(std::optional<double>* v) {
    const bool has_from = std::isfinite(m_range.from);
    double first = std::clamp(has_from ? m_range.from : 0.0, rule().min, rule().max);
    if (!has_from)
        first = std::clamp(first, std::isfinite(m_range.low) ? m_range.low : first,
                           std::isfinite(m_range.high) ? m_range.high : first);
    if (draw_own(*v, first))
        m_changed |= number(**v, rule(), m_range.low, m_range.high, m_label.unit);
}

void SceneForm::Row::operator()(std::optional<int>* v) {
    if (draw_own(*v, static_cast<int>(m_range.low)))
        m_changed |= whole_number(**v, rule(), m_range.low, m_range.high);
}

void SceneForm::Row::operator()(std::string* v) {
    if (rule().words.empty())
        draw_text(*v);
    else if (const auto word = draw_words(*v))
        *v = *word;
}

void SceneForm::Row::operator()(std::optional<std::array<double, 3>>* v) {
    if (!draw_own(*v, std::array<double, 3>{1, 1, 1}))
        return;
    std::array<float, 3> colour{};
    for (std::size_t i = 0; i < 3; ++i)
        colour[i] = static_cast<float>((**v)[i]);
    if (!ImGui::ColorEdit3("##v", colour.data(),
                           ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR))
        return;
    for (std::size_t i = 0; i < 3; ++i)
        (**v)[i] = std::clamp(static_cast<double>(colour[i]), rule().min, rule().max);
    m_changed = true;
}

void SceneForm::Row::draw_reset() {
    const bool is_usual =
        std::visit([&](auto* value) { return *value == *std::get<decltype(value)>(m_field.usual); },
                   m_field.value);
    if (!widgets::reset_button(!is_usual))
        return;
    std::visit([&](auto* value) { *value = *std::get<decltype(value)>(m_field.usual); },
               m_field.value);
    m_changed = true;
}

bool SceneForm::Row::draw() {
    ImGui::PushID(m_path.data(), m_path.data() + m_path.size());
    const float width = ImGui::GetContentRegionAvail().x;
    const float reset_width = ImGui::GetFrameHeight();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(m_label.name.c_str());
    widgets::tip(std::string(rule().doc));
    ImGui::SameLine(width * 0.42f);
    ImGui::SetNextItemWidth(width * 0.58f - reset_width - ImGui::GetStyle().ItemSpacing.x);
    std::visit([this](auto* value) { (*this)(value); }, m_field.value);
    widgets::report_place(std::string(m_path));
    ImGui::SameLine(width - reset_width);
    draw_reset();
    ImGui::PopID();
    return m_changed;
}

bool SceneForm::draw(std::string_view path, Field& field, const Range& range) {
    return Row(*this, path, field, range).draw();
}

}  // namespace terravox::panels
