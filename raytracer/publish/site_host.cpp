#include "raytracer/publish/site_host.hpp"

#include <civetweb.h>

#include <array>
#include <mutex>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/sockets/http_host.hpp"

namespace terravox::publish {
namespace {

constexpr const char* kBind = "127.0.0.1";

std::string_view header(const mg_connection* connection, const char* name) noexcept {
    const char* value = mg_get_header(connection, name);
    return value == nullptr ? std::string_view() : std::string_view(value);
}

}  // namespace

/// CivetWeb serves the files itself; it calls back on its own threads, through C, so no exception
/// may leave a callback.
class SiteHost::Impl {
public:
    Impl(const std::filesystem::path& folder, std::uint16_t port) : m_names(kBind) {
        static std::once_flag once;
        std::call_once(once, [] { mg_init_library(MG_FEATURES_DEFAULT); });
        mg_callbacks callbacks{};
        callbacks.begin_request = on_request;
        callbacks.log_message = on_log;
        const std::string listen = std::string(kBind) + ":" + std::to_string(port);
        const std::string root = folder.string();
        // Names and values alternate, as CivetWeb expects them.
        std::array settings = {"document_root", root.c_str(), "listening_ports", listen.c_str(),
                               "num_threads", "8",
                               // A site is files: none of them is run, whatever its name is.
                               "cgi_pattern", "", "ssi_pattern", "", "index_files", "index.html",
                               "enable_directory_listing", "no", "static_file_max_age", "0",
                               "access_control_allow_origin", "", "enable_auth_domain_check", "no",
                               "request_timeout_ms", "30000", static_cast<const char*>(nullptr)};
        m_context = mg_start(&callbacks, this, settings.data());
        if (m_context == nullptr) {
            const std::lock_guard lock(m_mutex);
            throw util::Error("serve the site on " + listen + ": " +
                              (m_message.empty() ? "CivetWeb could not start" : m_message) +
                              "; another --port may be free, 0 is any");
        }
        mg_server_port opened{};
        if (mg_get_server_ports(m_context, 1, &opened) == 1)
            m_port = static_cast<std::uint16_t>(opened.port);
    }
    ~Impl() { mg_stop(m_context); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    [[nodiscard]] std::uint16_t port() const noexcept { return m_port; }

private:
    // @return 0: CivetWeb serves the file; else the status that was sent
    static int on_request(mg_connection* connection) noexcept {
        constexpr int kMisdirected = 421;
        constexpr int kForbidden = 403;
        const auto& me = *static_cast<const Impl*>(mg_get_user_data(mg_get_context(connection)));
        const sockets::RequestingPage page{header(connection, "Host"), header(connection, "Origin"),
                                           header(connection, "Sec-Fetch-Site"),
                                           header(connection, "Sec-Fetch-Mode"),
                                           header(connection, "Sec-Fetch-Dest")};
        const std::string_view method = mg_get_request_info(connection)->request_method;
        if (!me.m_names.allow(page.host))
            return refuse(connection, kMisdirected);
        if (sockets::from_another_origin(page) || (method != "GET" && method != "HEAD"))
            return refuse(connection, kForbidden);
        return 0;
    }

    static int refuse(mg_connection* connection, int status) noexcept {
        mg_send_http_error(connection, status, "%s", "");
        return status;
    }

    static int on_log(const mg_connection* connection, const char* message) noexcept {
        try {
            util::log_debug("CivetWeb: {}", message);
            auto& me = *static_cast<Impl*>(mg_get_user_data(mg_get_context(connection)));
            const std::lock_guard lock(me.m_mutex);
            me.m_message = message;
        } catch (...) {  // the message is lost
        }
        return 1;
    }

    const sockets::HttpNames m_names;
    mg_context* m_context = nullptr;
    std::mutex m_mutex;
    std::string m_message;  ///< the last one, for a failed start
    std::uint16_t m_port = 0;
};

SiteHost::SiteHost(const std::filesystem::path& folder, std::uint16_t port)
    : m_impl(std::make_unique<Impl>(folder, port)) {}

SiteHost::~SiteHost() = default;

std::string SiteHost::address() const {
    return std::string("http://") + kBind + ":" + std::to_string(m_impl->port()) + "/";
}

}  // namespace terravox::publish
