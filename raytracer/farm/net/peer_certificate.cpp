#include "raytracer/farm/net/peer_certificate.hpp"

#include <grpc/grpc_security_constants.h>
#include <sys/stat.h>

#include <array>
#include <system_error>
#include <utility>

#include "common/util/log.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/openssl.hpp"

namespace terravox::net {
namespace {

void free_names(GENERAL_NAMES* names) noexcept {
    GENERAL_NAMES_free(names);
}

/// @return false if there is no such list, since nothing is revoked then
bool is_revoked(X509* certificate, const std::filesystem::path& ca) {
    const std::filesystem::path path = revocation_list_of(ca);
    std::error_code unknown;
    if (!std::filesystem::exists(path, unknown) && !unknown)
        return false;
    const auto failed = [&](const std::string& why) {
        return util::Error("read the revoked certificates " + path.string() + ": " + why);
    };
    const auto authority = certificates_of(text_of_pem(ca, "CA certificate"));
    const CrlPtr list = crl_of(text_of_pem(path, "list of revoked certificates"));
    if (!list)
        throw failed("it is no PEM of an X.509 CRL");
    if (authority.empty() ||
        X509_CRL_verify(list.get(), X509_get0_pubkey(authority.front().get())) != 1) {
        ERR_clear_error();
        throw failed("the CA " + ca.string() + " has not signed it");
    }
    X509_REVOKED* entry = nullptr;
    return X509_CRL_get0_by_cert(list.get(), &entry, certificate) == 1;
}

std::string common_name_of(X509* certificate) {
    std::array<char, 256> text{};
    const int size = X509_NAME_get_text_by_NID(X509_get_subject_name(certificate), NID_commonName,
                                               text.data(), static_cast<int>(text.size()));
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace

std::string role_of(X509* certificate) {
    const std::unique_ptr<GENERAL_NAMES, FreeBy<free_names>> names(static_cast<GENERAL_NAMES*>(
        X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
    if (!names)
        return {};
    for (int i = 0; i < sk_GENERAL_NAME_num(names.get()); ++i) {
        const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
        if (name->type != GEN_URI)
            continue;
        const ASN1_STRING* uri = name->d.uniformResourceIdentifier;
        const std::string_view text(reinterpret_cast<const char*>(ASN1_STRING_get0_data(uri)),
                                    static_cast<std::size_t>(ASN1_STRING_length(uri)));
        for (const std::string_view role : {kWorkerRole, kCoordinatorRole})
            if (text.starts_with(kRoleUri) && text.substr(kRoleUri.size()) == role)
                return std::string(role);
    }
    return {};
}

std::filesystem::path revocation_list_of(const std::filesystem::path& ca) {
    return std::filesystem::path(ca).replace_extension(".crl");
}

Certified certified_peer(const grpc::AuthContext& context, const std::filesystem::path& ca) {
    const auto shown = context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
    const auto chain = shown.empty()
                           ? std::vector<CertificatePtr>()
                           : certificates_of({shown.front().data(), shown.front().size()});
    if (chain.empty())
        throw RefusedError("it showed no certificate");
    X509* certificate = chain.front().get();
    if (X509_check_host(certificate, kFarmName.data(), kFarmName.size(),
                        X509_CHECK_FLAG_NEVER_CHECK_SUBJECT, nullptr) != 1)
        throw RefusedError("its certificate does not carry the name " + std::string(kFarmName));
    if (is_revoked(certificate, ca))
        throw RefusedError("its certificate is revoked");
    Certified out{role_of(certificate),
                  common_name_of(certificate),
                  {shown.front().data(), shown.front().size()}};
    if (out.role.empty())
        throw RefusedError(
            "its certificate names no role; terravox farm certs makes certificates with a role");
    return out;
}

RevocationWatch::RevocationWatch(std::string certificate, std::filesystem::path ca)
    : m_certificate(std::move(certificate)),
      m_ca(std::move(ca)),
      m_list(revocation_list_of(m_ca)) {}

RevocationWatch::Stamp RevocationWatch::stamp_of(const std::filesystem::path& file) noexcept {
    struct stat found{};
    if (::stat(file.c_str(), &found) != 0)
        return std::nullopt;
    const auto ns = [](const timespec& t) {
        return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
    };
    return {{static_cast<std::int64_t>(found.st_dev), static_cast<std::int64_t>(found.st_ino),
             static_cast<std::int64_t>(found.st_size), ns(found.st_mtim), ns(found.st_ctim)}};
}

bool RevocationWatch::is_revoked() {
    const std::lock_guard lock(m_mutex);
    // The stamp is taken first: a change while the list is read is noticed at the next check.
    const Stamp now = stamp_of(m_list);
    if (m_revoked || !now || now == m_read)
        return m_revoked;
    try {
        const auto chain = certificates_of(m_certificate);
        m_revoked = !chain.empty() && net::is_revoked(chain.front().get(), m_ca);
        m_read = now;
    } catch (const std::exception& e) {
        if (m_reported != now)
            util::log_warn("{}; links that are there go on", e.what());
        m_reported = now;
    }
    return m_revoked;
}

}  // namespace terravox::net
